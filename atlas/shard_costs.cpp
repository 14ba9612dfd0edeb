#include "atlas/shard_costs.h"

#include <filesystem>

#include "atlas/atomic_file.h"
#include "atlas/json_place.h"

namespace pluvia {
namespace {

constexpr int version = 1;

std::string cost_file(const std::string& folder) {
  return folder + "/cost.json";
}

}  // namespace

ShardCosts read_costs(const std::string& folder) {
  ShardCosts costs;
  const std::string file = cost_file(folder);
  if (!std::filesystem::exists(file)) return costs;
  const nlohmann::ordered_json json = parse_json(file, read_file(file));
  const JsonPlace document = {.value = &json, .file = file};
  check_version(document, version);
  const JsonPlace shards = member(document, "shards");
  if (!shards.value->is_object()) throw_at(shards, "not an object; expected an object");
  for (const auto& item : shards.value->items()) {
    costs[item.key()] = number_at(member(member(shards, item.key()), "cpu_s"));
  }
  return costs;
}

void write_costs(const std::string& folder, const ShardCosts& costs) {
  nlohmann::ordered_json json = {{"version", version},
                                 {"shards", nlohmann::ordered_json::object()}};
  for (const auto& [name, cpu_s] : costs) json["shards"][name] = {{"cpu_s", cpu_s}};
  write_file_atomically(cost_file(folder), json.dump(2) + "\n");
}

}  // namespace pluvia
