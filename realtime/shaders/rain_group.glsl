// Which of drop_groups a thread works on: a dispatch has rows of GROUPS_PER_ROW groups of threads,
// each of which has GROUP_SIZE / DROPS_OF_GROUP groups of drops.
uint group_index() { return gl_WorkGroupID.y * GROUPS_PER_ROW + gl_WorkGroupID.x; }
uint drop_group_index() {
  return (group_index() * GROUP_SIZE + gl_LocalInvocationID.x) / DROPS_OF_GROUP;
}
uint place_in_drop_group() { return gl_LocalInvocationID.x % DROPS_OF_GROUP; }
