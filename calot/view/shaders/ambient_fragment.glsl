// Half as wide and high as the picture: how open each place is to light from around, from the depths near it (alchemy's
// estimator [McGuire2011]), and how much of the lamp reaches it.
#define SOFT
#include "frame.glsl"
#include "material.glsl"
#include "light.glsl"
uniform sampler2D depth_map;
in vec2 at;
out vec4 color;

vec3 place(vec2 p) {
  float depth = view_depth(texture(depth_map, p).r);
  vec2 slope = (2.0 * p - 1.0) * vec2(right.w, up.w);
  return vec3(slope * depth, depth);
}

void main() {
  vec3 here = place(at);
  vec3 dx = dFdx(here), dy = dFdy(here);
  vec3 n = normalize(cross(dx, dy));
  if (n.z > 0.0) n = -n;
  const float reach = 0.007;  // [m]
  float size = clamp(reach / (here.z * up.w) * 0.5, 0.004, 0.12);
  float turn = 6.2831853 * pixel_noise(floor(gl_FragCoord.xy));
  float blocked = 0.0;
  for (int i = 0; i < 7; ++i) {
    float radius = size * (float(i) + 0.6) / 7.0, angle = turn + 2.3999632 * float(i);
    vec3 to = place(at + radius * vec2(cos(angle) * viewport.y * viewport.z, sin(angle))) - here;
    float d2 = dot(to, to);
    blocked += max(dot(to, n) - 0.0004, 0.0) / (d2 + 1e-6) * step(d2, reach * reach) * reach;
  }
  vec3 normal = n.x * right.xyz + n.y * up.xyz + n.z * forward.xyz;
  vec3 position = eye.xyz + here.x * right.xyz + here.y * up.xyz + here.z * forward.xyz;
  float lamp = lamp_visibility(position, normal, length(light.xyz - position));
  color = vec4(max(0.0, 1.0 - 0.16 * blocked), lamp, here.z, 1.0);
}
