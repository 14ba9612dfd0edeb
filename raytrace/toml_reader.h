// Reading human-written TOML strictly: a missing key, a wrong type, a value out of range or a key
// that nobody asked for throws std::runtime_error
//   FILE:LINE:COL: what was found; what is expected
// (an unknown key also names the nearest known one). nan and inf, which TOML can say, are refused.
// An integer is accepted where a real number is wanted, never the other way round.
#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>
#include <Eigen/Core>

namespace pluvia {

// Parses the file; syntax errors and keys given twice carry FILE:LINE:COL too. Throws
// "FILE: cannot read: REASON; expected a readable TOML file" when it cannot be read.
toml::table read_toml(const std::string& file);

struct Range {
  double low = -1e300;
  double high = 1e300;
  bool low_open = false;  // true: value > low instead of >=
};

// One table of the file. Each call below marks its key as known; finish() refuses whatever is left.
// The optional forms leave `value` alone when the key is absent. The table must outlive the reader.
class TomlReader {
 public:
  // name: how messages call the table, "" for the whole file.
  TomlReader(const toml::table& table, std::string file, std::string name);

  void required(const char* key, double& value, const Range& range, const char* unit = "");
  void optional(const char* key, double& value, const Range& range, const char* unit = "");
  void required(const char* key, int& value, int low, int high);
  void optional(const char* key, int& value, int low, int high);
  void optional(const char* key, unsigned long long& value);  // >= 0
  void optional(const char* key, bool& value);
  void required(const char* key, std::string& value);
  void optional(const char* key, std::string& value);
  void required(const char* key, Eigen::Vector3d& value, const Range& range = {});
  void optional(const char* key, Eigen::Vector3d& value, const Range& range = {});
  void optional(const char* key, std::vector<int>& value, int low, int high);
  void required(const char* key, std::vector<double>& value, const Range& range,
                const char* unit = "");
  bool has(const char* key);                        // marks the key as known, too
  TomlReader table(const char* key);                // required sub-table
  std::vector<TomlReader> tables(const char* key);  // array of tables; absent: empty

  // Throws for the first key in the file that no call above asked for.
  void finish() const;

  // Throws "FILE:LINE:COL: MESSAGE" at the key's place (the table's own place when the key is
  // absent).
  [[noreturn]] void refuse(const char* key, const std::string& message) const;

  const std::string& file() const { return file_; }

 private:
  const toml::node* find(const char* key);
  const toml::node& find_required(const char* key, const std::string& expected);
  [[noreturn]] void refuse_value(const char* key, const std::string& found,
                                 const std::string& expected) const;
  double number(const char* key, const toml::node& node, const Range& range,
                const std::string& expected, const std::string& suffix = "") const;
  int integer(const char* key, const toml::node& node, int low, int high,
              const std::string& suffix = "") const;
  Eigen::Vector3d vector(const char* key, const toml::node& node, const Range& range) const;
  std::string full_name(const std::string& key) const;

  const toml::table* table_;
  std::string file_;
  std::string name_;
  std::vector<std::string> known_ = {};
};

// FILE's folder joined with a path that the file names (absolute paths stay).
std::string path_beside(const std::string& file, const std::string& path);

}  // namespace pluvia
