// Which of drop_groups this group of threads works on: a dispatch has rows of GROUPS_PER_ROW.
uint group_index() { return gl_WorkGroupID.y * GROUPS_PER_ROW + gl_WorkGroupID.x; }
