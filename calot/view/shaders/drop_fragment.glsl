// A drop in flight.
#include "frame.glsl"
#include "material.glsl"
#include "light.glsl"
#include "tone.glsl"
#include "output.glsl"
#include "particle.glsl"
in vec3 position;
flat in vec3 middle, axis, side;
flat in float radius;
flat in vec4 look;  // bile
in vec2 on_square;
out vec4 color;

void main() {
  vec3 n = drop_normal(on_square, side, axis, cross(side, axis));
  if (dot(n, n) < 0.5) discard;
  Material m = liquid(radius, look.x, 0.0);
  float solid = smoothstep(1.0, 0.8, dot(on_square, on_square));
  color = vec4(shown(shade(m, n, position, n, 1.0)) * solid, solid);
}
