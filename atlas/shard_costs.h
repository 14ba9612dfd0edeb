// DIR/cost.json of a streak database: what each shard cost to trace. Outside the promise of same
// bytes.
#pragma once

#include <map>
#include <string>

namespace pluvia {

using ShardCosts = std::map<std::string, double>;  // name of a shard -> CPU seconds

// Empty where there is no file. Throws std::runtime_error for a damaged one: other runs' seconds
// are not thrown away unasked.
ShardCosts read_costs(const std::string& folder);

void write_costs(const std::string& folder, const ShardCosts& costs);

}  // namespace pluvia
