// The round field as a disc, or the whole picture as one triangle (SCREEN).
#include "frame.glsl"
out vec2 at;  // 0 ... 1 over the picture

void main() {
#ifdef SCREEN
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
#else
  float angle = 6.2831853 * float(gl_VertexID) / 96.0;
  vec2 corner = 2.0 * scope.x * 1.0006 * vec2(cos(angle), sin(angle)) * viewport.zw;
#endif
  at = 0.5 * corner + 0.5;
  gl_Position = vec4(corner, 0.0, 1.0);
}
