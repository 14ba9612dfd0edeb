#include <fstream>
#include <string>
#include <thread>

#include <OpenEXR/OpenEXRConfig.h>
#include <OpenImageIO/oiioversion.h>
#include <ceres/version.h>
#include <embree3/rtcore_config.h>
#include <fmt/format.h>
#include <sys/utsname.h>
#include <tbb/version.h>
#include <unistd.h>
#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "validate/report.h"

namespace pluvia {
namespace {

#ifdef __clang__
constexpr const char* compiler = __VERSION__;  // begins with its name
#else
constexpr const char* compiler = "g++ " __VERSION__;
#endif

// What follows the separator in the first line of the file that begins with `key`; "unknown" when
// there is none.
std::string line_value(const char* file, const std::string& key, char separator) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t at = line.find(separator);
    if (line.rfind(key, 0) != 0 || at == std::string::npos) continue;
    const std::size_t begin = line.find_first_not_of(" \t\"", at + 1);
    const std::size_t end = line.find_last_not_of(" \t\"");
    return begin == std::string::npos ? "unknown" : line.substr(begin, end + 1 - begin);
  }
  return "unknown";
}

std::string kernel() {
  utsname name = {};
  return uname(&name) == 0 ? fmt::format("{} {} {}", name.sysname, name.release, name.machine)
                           : "unknown";
}

}  // namespace

std::vector<std::pair<std::string, std::string>> describe_machine() {
  const double memory_bytes =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return {{"Pluvia", PLUVIA_VERSION},
          {"processor", line_value("/proc/cpuinfo", "model name", ':')},
          {"cores", fmt::format("{}", std::thread::hardware_concurrency())},
          {"memory", fmt::format("{:.1f} GiB", memory_bytes / (1 << 30))},
          {"system", line_value("/etc/os-release", "PRETTY_NAME", '=')},
          {"kernel", kernel()},
          {"compiler", compiler},
          {"Embree", RTC_VERSION_STRING},
          {"Eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"Ceres", CERES_VERSION_STRING},
          {"TBB", TBB_VERSION_STRING},
          {"OpenEXR", OPENEXR_VERSION_STRING},
          {"OpenImageIO", OIIO_VERSION_STRING},
          {"nlohmann JSON", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR,
                                        NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH)},
          {"fmt", fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100,
                              FMT_VERSION % 100)},
          {"CLI11", CLI11_VERSION}};
}

}  // namespace pluvia
