#include "raytrace/wide_paths.h"

#include <algorithm>
#include <cassert>

#include "raytrace/wide_queue.h"

// Of Highway's instruction sets only these two: compiled here one after the other.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raytrace/wide_paths.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3
#include "raytrace/wide_tracer-inl.h"
#endif

#if HWY_ONCE
namespace pluvia {

namespace {

// Hits traced together: their queues stay within a second-level cache.
constexpr std::size_t block_hits = 128;

TraceBlock trace_block_of(Isa isa) {
  return isa == Isa::avx512 ? N_AVX3::trace_block : N_AVX2::trace_block;
}

void add(PathRemainder& sum, const PathRemainder& more) {
  sum.beyond_order += more.beyond_order;
  sum.given_up += more.given_up;
  sum.lost += more.lost;
}

// Moves a block's exits to the end of the result, sorted by their hits.
void gather(const WideBlock& block, HitExits& result) {
  const ExitQueue& queue = block.exits;
  const auto hit_of = [&](std::size_t k) { return static_cast<std::uint32_t>(queue.word[k]); };
  const std::size_t first_hit = result.first_exit.size();
  const std::uint32_t before = result.first_exit.back();
  result.first_exit.resize(first_hit + block.remainder.size(), 0);
  std::uint32_t* const ends = result.first_exit.data() + first_hit;
  for (std::size_t k = 0; k < queue.count; ++k) ++ends[hit_of(k)];
  std::vector<std::uint32_t> next(block.remainder.size());
  std::uint32_t sum = before;
  for (std::size_t hit = 0; hit < next.size(); ++hit) {
    next[hit] = sum;
    sum += ends[hit];
    ends[hit] = sum;
  }
  result.exits.resize(sum);
  for (std::size_t k = 0; k < queue.count; ++k) {
    PathExit& exit = result.exits[next[hit_of(k)]++];
    exit.signature = queue.signature[k];
    exit.order = static_cast<int>((queue.word[k] & ~beyond_outline) >> order_shift);
    exit.direction = {queue.value[0][k], queue.value[1][k], queue.value[2][k]};
    exit.throughput = queue.value[3][k];
    exit.incident = {queue.value[4][k], queue.value[5][k], queue.value[6][k]};
    exit.normal = {queue.value[7][k], queue.value[8][k], queue.value[9][k]};
    exit.power_s = queue.value[10][k];
    exit.power_p = queue.value[11][k];
    exit.refracted = queue.value[12][k] != 0;
  }
  for (const PathRemainder& left : block.remainder) add(result.remainder, left);
}

HitExits trace_one_by_one(const WideScene& scene, std::span<const CameraHit> hits) {
  HitExits result;
  for (const CameraHit& hit : hits) {
    add(result.remainder, trace_exits(scene.drop, hit.position_m, hit.normal, scene.to_camera,
                                      scene.options, result.exits));
    result.first_exit.push_back(static_cast<std::uint32_t>(result.exits.size()));
  }
  return result;
}

}  // namespace

HitExits trace_exits_of(const DropInstant& drop, std::span<const CameraHit> hits,
                        const Eigen::Vector3d& to_camera, const PathOptions& options, Isa isa) {
  assert(cpu_has(isa));
  const WideScene scene = {drop, to_camera, options};
  if (isa == Isa::scalar) return trace_one_by_one(scene, hits);
  const TraceBlock trace_block = trace_block_of(isa);
  HitExits result;
  result.first_exit.reserve(hits.size() + 1);
  // Kept between calls: small batches would spend half their time on its memory, some 100 kB.
  thread_local WideBlock block;
  for (std::size_t i = 0; i < hits.size(); i += block_hits) {
    trace_block(scene, hits.subspan(i, std::min(block_hits, hits.size() - i)), block);
    // Later hits have about as many exits as the first ones.
    if (i == 0) result.exits.reserve(block.exits.count * (hits.size() / block_hits + 1));
    gather(block, result);
  }
  return result;
}

}  // namespace pluvia
#endif
