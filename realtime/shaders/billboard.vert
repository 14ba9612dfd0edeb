#version 450 core
// One point for each place of each group of drops; the geometry shader finds out whether there is a
// drop.
flat out int drop_index;

void main() {
  drop_index = gl_VertexID;
  gl_Position = vec4(0, 0, 0, 1);
}
