// How true a streak database is: every point light's picture against that of a database of the same
// preset, traced much finer and with another seed. What is printed as error holds the finer
// database's own, whose estimate stands beside it.
#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "atlas/atomic_file.h"
#include "validate/batch_judge.h"
#include "validate/light_errors.h"

namespace pluvia {
namespace {

struct DatabaseFlags {
  std::string database = {}, reference = {}, csv = {};
};

void refuse_unequal(const Shard& ours, const Shard& reference, const std::string& name) {
  if (ours.width_px == reference.width_px && ours.height_px == reference.height_px &&
      ours.lights == reference.lights && ours.bands == reference.bands) {
    return;
  }
  throw std::runtime_error(name + ": other sizes, lights or bands than the reference's");
}

struct Comparison {
  std::vector<LightError> errors = {};
  std::size_t shards = 0, dark = 0, missing = 0;
};

Comparison compare(const DatabaseFlags& flags) {
  const Manifest ours = read_manifest(flags.database), finer = read_manifest(flags.reference);
  Comparison result;
  for (const ShardRecord& record : ours.shards) {
    const auto same = std::find_if(finer.shards.begin(), finer.shards.end(),
                                   [&](const ShardRecord& r) { return r.key == record.key; });
    if (same == finer.shards.end()) {
      ++result.missing;
      continue;
    }
    const std::string name = shard_name(record.key);
    const Shard shard = read_whole_shard(flags.database, record);
    const Shard reference = read_whole_shard(flags.reference, *same);
    refuse_unequal(shard, reference, flags.database + "/" + record.file);
    ++result.shards;
    for (std::size_t k = 0; k < shard.light.size(); ++k) {
      LightError error = light_error(shard.light[k], reference.light[k]);
      if (error.flux == 0) {
        ++result.dark;
        continue;
      }
      error.shard = name;
      error.light = light_name(shard.lights[k]);
      result.errors.push_back(error);
    }
  }
  return result;
}

void print_row(const std::string& name, const std::vector<LightError>& errors) {
  fmt::print("{:<18} {:6}  {:<22} {:<22} {:<22} {:<22} {:+.3f}\n", name, errors.size(),
             spread(errors, &LightError::image), spread(errors, &LightError::estimate),
             spread(errors, &LightError::reference_estimate),
             spread(errors, &LightError::flux_error), 100 * total_flux_error(errors));
}

void print_groups(const std::vector<LightError>& errors,
                  const std::function<std::string(const LightError&)>& group_of) {
  std::map<std::string, std::vector<LightError>> groups;
  for (const LightError& error : errors) groups[group_of(error)].push_back(error);
  for (const auto& [name, group] : groups) print_row(name, group);
}

// What a shard promises is its lights' 90th percentile: how it compares with the estimate's.
void print_promises(const std::vector<LightError>& errors) {
  std::map<std::string, std::array<std::vector<double>, 2>> shards;
  for (const LightError& error : errors) {
    shards[error.shard][0].push_back(error.image);
    shards[error.shard][1].push_back(error.estimate);
  }
  std::vector<double> ratios;
  for (const auto& [name, values] : shards) {
    const double estimate = quantile(values[1], 0.9);
    if (estimate > 0) ratios.push_back(quantile(values[0], 0.9) / estimate);
  }
  if (ratios.empty()) return;
  fmt::print("a shard's 90th percentile over the estimate's: median {:.2f}, greatest {:.2f}\n",
             quantile(ratios, 0.5), quantile(ratios, 1));
}

std::string csv_of(const std::vector<LightError>& errors) {
  std::string text = "shard,light,reference_flux_px,error,flux_error,estimate,reference_estimate\n";
  for (const LightError& e : errors) {
    text += fmt::format("{},{},{},{},{},{},{}\n", e.shard, e.light, e.flux, e.image, e.flux_error,
                        e.estimate, e.reference_estimate);
  }
  return text;
}

void judge(const DatabaseFlags& flags) {
  const Comparison found = compare(flags);
  fmt::print("{} shards, {} lights; {} shards are not in the reference, {} lights are dark in it\n",
             found.shards, found.errors.size(), found.missing, found.dark);
  fmt::print(
      "median / 90th percentile / greatest, %\n{:<18} {:>6}  {:<22} {:<22} {:<22} {:<22} {}\n", "",
      "lights", "error of the picture", "own estimate", "reference's estimate", "error of the flux",
      "all flux");
  print_groups(found.errors, [](const LightError& e) { return e.shard; });
  print_groups(found.errors, [](const LightError& e) {
    return "view " + e.shard.substr(e.shard.rfind('v') + 1);
  });
  print_row("all", found.errors);
  print_promises(found.errors);
  if (!flags.csv.empty()) write_file_atomically(flags.csv, csv_of(found.errors));
}

}  // namespace
}  // namespace pluvia

int main(int argc, char** argv) {
  CLI::App app("The pictures of a streak database against a finer one's", "database_accuracy");
  pluvia::DatabaseFlags flags;
  app.add_option("database", flags.database, "folder")->required();
  app.add_option("reference", flags.reference, "folder of the finer one")->required();
  app.add_option("--csv", flags.csv, "file for the figures of every light");
  CLI11_PARSE(app, argc, argv);
  try {
    pluvia::judge(flags);
  } catch (const std::exception& error) {
    fmt::print(stderr, "database_accuracy: {}\n", error.what());
    return 1;
  }
  return 0;
}
