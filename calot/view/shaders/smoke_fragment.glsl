// A puff of smoke or steam, lit by the lamp that it is in, fading where it meets tissue and right before the lens.
#include "frame.glsl"
#include "material.glsl"
#include "noise.glsl"
#include "smoke.glsl"
#include "tone.glsl"
#include "output.glsl"
uniform sampler2D depth_map;
in vec3 position;
flat in float radius;
flat in vec4 look;  // optical depth, turn, seed, steam
in vec2 on_square;
out vec4 color;

void main() {
  float behind = view_depth(texelFetch(depth_map, ivec2(gl_FragCoord.xy), 0).r);
  float here = dot(position - eye.xyz, forward.xyz);
  float opacity = smoke_opacity(on_square, look.x, look.y, look.z) * smoothstep(0.004, 0.025, here);
  opacity *= smoke_softness(behind - here + 0.3 * radius, radius);
  color = vec4(shown(smoke_light(position, look.w)) * opacity, opacity);
}
