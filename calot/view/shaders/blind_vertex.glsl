// All that lies outside the round field, as a ring right before the camera: nothing is drawn behind it.
#include "frame.glsl"

void main() {
  float angle = 6.2831853 * float(gl_VertexID / 2) / 96.0;
  float radius = gl_VertexID % 2 == 0 ? scope.x * 1.0006 : length(viewport.xy);
  gl_Position = vec4(2.0 * radius * vec2(cos(angle), sin(angle)) * viewport.zw, -1.0, 1.0);
}
