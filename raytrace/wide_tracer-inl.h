// The waves of raytrace/exit_paths.h: all walkers of a block advance to their next interface and
// split there; the children are the next wave.
//
// What a hit gets does not depend on the block it is in. Children keep the order of their parents,
// exits and powers are taken down lane by lane: for one hit always in the same order.
#if defined(PLUVIA_WIDE_TRACER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PLUVIA_WIDE_TRACER_INL
#undef PLUVIA_WIDE_TRACER_INL
#else
#define PLUVIA_WIDE_TRACER_INL
#endif

#include <algorithm>
#include <array>
#include <utility>

#include "raytrace/exit_paths.h"
#include "raytrace/wide_optics-inl.h"
#include "raytrace/wide_queue.h"

HWY_BEFORE_NAMESPACE();
namespace pluvia::HWY_NAMESPACE {

using WordTag = hn::ScalableTag<std::uint64_t>;
using Words = hn::Vec<WordTag>;

HWY_INLINE Words all_words(std::uint64_t value) {
  return hn::Set(WordTag(), value);
}

struct WalkerLanes {
  Lanes3 position;
  BeamLanes beam;
  Words signature, word;
};

// The interface that walkers outside have left.
struct LastLanes {
  Lanes3 incident, normal;
  Lanes power_s, power_p, refracted;
};

template <typename Queue>
HWY_INLINE Lanes3 load3(const Queue& q, std::size_t component, std::size_t i) {
  return {hn::LoadU(Tag(), q.value[component].data() + i),
          hn::LoadU(Tag(), q.value[component + 1].data() + i),
          hn::LoadU(Tag(), q.value[component + 2].data() + i)};
}

template <typename Queue>
HWY_INLINE WalkerLanes load_walkers(const Queue& q, std::size_t i) {
  const Lanes3 powers = load3(q, 9, i);
  return {load3(q, 0, i),
          {load3(q, 3, i),
           load3(q, 6, i),
           {powers.x, powers.y, powers.z, hn::LoadU(Tag(), q.value[12].data() + i)}},
          hn::LoadU(WordTag(), q.signature.data() + i),
          hn::LoadU(WordTag(), q.word.data() + i)};
}

HWY_INLINE LastLanes load_last(const OutsideQueue& q, std::size_t i) {
  const Lanes3 powers = load3(q, walker_components + 6, i);
  return {load3(q, walker_components, i), load3(q, walker_components + 3, i), powers.x, powers.y,
          powers.z};
}

// Entry `bits`: the places of its set bits, ascending.
using PlaceTable = std::array<std::array<std::uint64_t, lane_count>, 1 << lane_count>;

constexpr PlaceTable make_place_table() {
  PlaceTable table = {};
  for (std::size_t bits = 0; bits < table.size(); ++bits) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < lane_count; ++k) {
      if ((bits >> k & 1) != 0) table[bits][count++] = k;
    }
  }
  return table;
}

constexpr PlaceTable place_table = make_place_table();

// Appends the lanes of `mask`, in their order. (Highway 1.0's Compress copies its table each time.)
template <std::size_t Count>
HWY_INLINE void append(LaneQueue<Count>& q, LaneMask mask, const Lanes (&value)[Count],
                       Words signature, Words word) {
  q.make_room(lane_count);
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(Tag(), mask, bits);
  const Words place = hn::LoadU(WordTag(), place_table[bits[0]].data());
  const auto to_front = hn::IndicesFromVec(Tag(), place);
  const auto words_to_front = hn::IndicesFromVec(WordTag(), place);
  for (std::size_t k = 0; k < Count; ++k) {
    hn::StoreU(hn::TableLookupLanes(value[k], to_front), Tag(), q.value[k].data() + q.count);
  }
  hn::StoreU(hn::TableLookupLanes(signature, words_to_front), WordTag(),
             q.signature.data() + q.count);
  hn::StoreU(hn::TableLookupLanes(word, words_to_front), WordTag(), q.word.data() + q.count);
  q.count += hn::CountTrue(Tag(), mask);
}

HWY_INLINE void append_inside(InsideQueue& q, LaneMask mask, const WalkerLanes& w) {
  const Lanes value[walker_components] = {
      w.position.x,       w.position.y,    w.position.z,   w.beam.direction.x, w.beam.direction.y,
      w.beam.direction.z, w.beam.axis.x,   w.beam.axis.y,  w.beam.axis.z,      w.beam.light.s,
      w.beam.light.p,     w.beam.light.re, w.beam.light.im};
  append(q, mask, value, w.signature, w.word);
}

HWY_INLINE void append_outside(OutsideQueue& q, LaneMask mask, const WalkerLanes& w,
                               const LastLanes& last) {
  const Lanes value[walker_components + last_components] = {
      w.position.x,       w.position.y,    w.position.z,    w.beam.direction.x, w.beam.direction.y,
      w.beam.direction.z, w.beam.axis.x,   w.beam.axis.y,   w.beam.axis.z,      w.beam.light.s,
      w.beam.light.p,     w.beam.light.re, w.beam.light.im, last.incident.x,    last.incident.y,
      last.incident.z,    last.normal.x,   last.normal.y,   last.normal.z,      last.power_s,
      last.power_p,       last.refracted};
  append(q, mask, value, w.signature, w.word);
}

HWY_INLINE void append_exits(ExitQueue& q, LaneMask mask, const WalkerLanes& w, Lanes throughput,
                             const LastLanes& last) {
  const Lanes3& d = w.beam.direction;
  const Lanes value[4 + last_components] = {d.x,
                                            d.y,
                                            d.z,
                                            throughput,
                                            last.incident.x,
                                            last.incident.y,
                                            last.incident.z,
                                            last.normal.x,
                                            last.normal.y,
                                            last.normal.z,
                                            last.power_s,
                                            last.power_p,
                                            last.refracted};
  append(q, mask, value, w.signature, w.word);
}

HWY_INLINE LastLanes last_interface(const WalkerLanes& walker, const Lanes3& normal,
                                    const SplitLanes& split, double refracted) {
  return {walker.beam.direction, normal, split.power_s, split.power_p, all(refracted)};
}

// The walkers after a split, on their way with one of the two beams.
HWY_INLINE WalkerLanes child(const WalkerLanes& parent, const Lanes3& position,
                             const BeamLanes& beam, bool transmitted) {
  const Words signature = parent.signature * all_words(signature_factor) +
                          all_words(transmitted ? transmitted_term : reflected_term);
  return {position, beam, signature, parent.word};
}

// Light of hits beyond the outline counts negative.
HWY_INLINE Lanes signed_lanes(Lanes light, Words word) {
  return hn::Or(light, hn::BitCast(Tag(), hn::And(word, all_words(beyond_outline))));
}

HWY_INLINE LastLanes signed_powers(LastLanes last, Words word) {
  last.power_s = signed_lanes(last.power_s, word);
  last.power_p = signed_lanes(last.power_p, word);
  return last;
}

struct Waves {
  const PathOptions& options;
  WideBlock& block;
  DropLanes drop;

  // Adds shares to the sums of their hits; hits beyond the outline have none.
  void take_down(Lanes share, Words word, double PathRemainder::*sum) {
    if (hn::AllTrue(Tag(), share == hn::Zero(Tag()))) return;
    double shares[lane_count];
    std::uint64_t words[lane_count];
    hn::StoreU(share, Tag(), shares);
    hn::StoreU(word, WordTag(), words);
    for (std::size_t k = 0; k < lane_count; ++k) {
      if (shares[k] == 0 || (words[k] & beyond_outline) != 0) continue;
      block.remainder[static_cast<std::uint32_t>(words[k])].*sum += shares[k];
    }
  }

  // Takes the children of a split into the next wave, as far as the options allow.
  void push(LaneMask in, WalkerLanes inward, LaneMask out, const WalkerLanes& outward,
            const LastLanes& last) {
    inward.word = inward.word + all_words(one_order);
    const Words order =
        hn::ShiftRight<order_shift>(hn::AndNot(all_words(beyond_outline), inward.word));
    const auto most = all_words(static_cast<std::uint64_t>(options.max_order));
    const LaneMask beyond = hn::And(in, hn::RebindMask(Tag(), order > most));
    in = hn::AndNot(beyond, in);
    const Lanes share_in = power_lanes(inward.beam.light);
    const Lanes share_out = power_lanes(outward.beam.light);
    const LaneMask weak_in = hn::And(in, share_in < all(options.min_power));
    const LaneMask weak_out = hn::And(out, share_out < all(options.min_power));
    take_down(hn::IfThenElseZero(beyond, share_in), inward.word, &PathRemainder::beyond_order);
    take_down(hn::IfThenElseZero(weak_in, share_in) + hn::IfThenElseZero(weak_out, share_out),
              inward.word, &PathRemainder::given_up);
    append_inside(block.next_inside, hn::AndNot(weak_in, in), inward);
    append_outside(block.next_outside, hn::AndNot(weak_out, out), outward, last);
  }

  // Splits the walkers of `mask` at an interface.
  template <RaySide side>
  HWY_INLINE void meet(const WalkerLanes& walker, LaneMask mask, const MeetingLanes& at) {
    constexpr bool outside = side == RaySide::outside;
    const Lanes3 normal = outside ? at.normal : times(at.normal, all(-1.0));
    const LaneMask against = dot(normal, walker.beam.direction) < hn::Zero(Tag());
    const LaneMask touch = hn::AndNot(against, mask);  // a tangent touch, to rounding
    take_down(hn::IfThenElseZero(touch, power_lanes(walker.beam.light)), walker.word,
              &PathRemainder::lost);
    mask = hn::And(mask, against);
    const double ratio = outside ? 1 / options.refractive_index : options.refractive_index;
    const SplitLanes split = split_lanes(walker.beam, normal, ratio);
    const LaneMask partly = hn::AndNot(split.total, mask);
    const WalkerLanes reflected = child(walker, at.position, split.reflected, false);
    const WalkerLanes refracted = child(walker, at.position, split.refracted, true);
    const LastLanes last = last_interface(walker, normal, split, outside ? 0 : 1);
    if (outside) {
      push(partly, refracted, mask, reflected, last);
    } else {
      append_exits(block.exits, hn::And(mask, split.total), refracted, hn::Zero(Tag()),
                   signed_powers(last, walker.word));
      push(mask, reflected, partly, refracted, last);
    }
  }

  void advance_inside(const InsideQueue& walkers) {
    for (std::size_t i = 0; i < walkers.count; i += lane_count) {
      const WalkerLanes w = load_walkers(walkers, i);
      const LaneMask here = hn::FirstN(Tag(), walkers.count - i);
      const RayLanes ray = ray_lanes(w.position, w.beam.direction);
      const RootLanes root = first_root_lanes<RaySide::inside>(drop, ray, here);
      take_down(hn::IfThenElseZero(hn::AndNot(root.found, here), power_lanes(w.beam.light)), w.word,
                &PathRemainder::lost);
      meet<RaySide::inside>(w, root.found, meeting_lanes(root.point));
    }
  }

  void advance_outside(const OutsideQueue& walkers) {
    for (std::size_t i = 0; i < walkers.count; i += lane_count) {
      const WalkerLanes w = load_walkers(walkers, i);
      const LaneMask here = hn::FirstN(Tag(), walkers.count - i);
      const RayLanes ray = ray_lanes(w.position, w.beam.direction);
      const RootLanes root = first_root_lanes<RaySide::outside>(drop, ray, here);
      LastLanes last = signed_powers(load_last(walkers, i), w.word);
      last.power_s = hn::IfThenZeroElse(root.found, last.power_s);
      last.power_p = hn::IfThenZeroElse(root.found, last.power_p);
      const Lanes light = signed_lanes(power_lanes(w.beam.light), w.word);
      append_exits(block.exits, here, w, hn::IfThenZeroElse(root.found, light), last);
      if (hn::AllFalse(Tag(), root.found)) continue;
      meet<RaySide::outside>(w, root.found, meeting_lanes(root.point));
    }
  }

  // The first interface, at the hits themselves; beyond the outline only refracted light goes on.
  void start(WalkerLanes w, LaneMask here, const MeetingLanes& at) {
    const LaneMask beyond = hn::And(here, dot(at.normal, w.beam.direction) >= hn::Zero(Tag()));
    const LaneMask seen = hn::AndNot(beyond, here);
    const auto mark = hn::RebindMask(WordTag(), beyond);
    w.word = hn::Or(w.word, hn::IfThenElseZero(mark, all_words(beyond_outline)));
    const SplitLanes split = split_lanes(w.beam, at.normal, 1 / options.refractive_index);
    const WalkerLanes reflected = child(w, at.position, split.reflected, false);
    const WalkerLanes refracted = child(w, at.position, split.refracted, true);
    const LastLanes last = last_interface(w, at.normal, split, 0);
    append_exits(block.exits, beyond, reflected, power_lanes(split.reflected.light), last);
    push(hn::AndNot(split.total, here), refracted, seen, reflected, last);
  }

  void start_all(const WideScene& scene, std::span<const CameraHit> hits) {
    const BeamLanes camera = unpolarised_lanes(all(Eigen::Vector3d(-scene.to_camera)));
    const Words first = hn::Iota(WordTag(), 0);
    for (std::size_t i = 0; i < hits.size(); i += lane_count) {
      const std::size_t count = std::min(lane_count, hits.size() - i);
      LaneVectors positions, normals;
      for (std::size_t k = 0; k < count; ++k) {
        const CameraHit& hit = hits[i + k];
        positions.put(k, (hit.position_m - scene.drop.origin_m) / scene.drop.surface.scale);
        normals.put(k, hit.normal);
      }
      const MeetingLanes at = {load(positions), load(normals)};
      const WalkerLanes w = {at.position, camera, all_words(1), first + all_words(i)};
      start(w, hn::FirstN(Tag(), count), at);
    }
  }
};

inline void trace_block(const WideScene& scene, std::span<const CameraHit> hits, WideBlock& block) {
  block.exits.count = block.next_inside.count = block.next_outside.count = 0;
  block.remainder.assign(hits.size(), {});
  Waves waves{scene.options, block, DropLanes(scene.drop)};
  waves.start_all(scene, hits);
  while (block.next_inside.count + block.next_outside.count > 0) {
    std::swap(block.inside, block.next_inside);
    std::swap(block.outside, block.next_outside);
    block.next_inside.count = block.next_outside.count = 0;
    waves.advance_inside(block.inside);
    waves.advance_outside(block.outside);
  }
}

}  // namespace pluvia::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
