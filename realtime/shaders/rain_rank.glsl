// The rank of a visible streak among the visible ones of its group, in order. Not an atomic
// append: its order would differ from run to run, and with it the rounding of sums.
shared uint visible_bits[GROUP_SIZE / 32];

uint rank_in_group(bool visible, out uint total) {
  uint i = gl_LocalInvocationID.x;
  if (i < GROUP_SIZE / 32) visible_bits[i] = 0u;
  barrier();
  if (visible) atomicOr(visible_bits[i / 32u], 1u << (i % 32u));
  barrier();
  uint rank = 0u;
  total = 0u;
  for (uint word = 0u; word < GROUP_SIZE / 32; ++word) {
    uint before = word < i / 32u ? 0xffffffffu : word == i / 32u ? (1u << (i % 32u)) - 1u : 0u;
    rank += uint(bitCount(visible_bits[word] & before));
    total += uint(bitCount(visible_bits[word]));
  }
  return rank;
}
