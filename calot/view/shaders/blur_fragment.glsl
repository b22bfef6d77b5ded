// Smooths ambient light and shadow over the pattern of their samples, not across edges in depth.
#include "frame.glsl"
uniform sampler2D color_map;  // openness, lamp, depth [m]
in vec2 at;
out vec4 color;

void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  vec4 middle = texelFetch(color_map, here, 0);
  ivec2 last = textureSize(color_map, 0) - 1;
  vec3 sum = vec3(middle.rg, 1.0);
  float narrow = 300.0 / (1.0 + 8.0 * middle.b);
  for (int y = -2; y <= 2; ++y)
    for (int x = -2; x <= 2; ++x) {
      vec4 other = texelFetch(color_map, clamp(here + ivec2(x, y), ivec2(0), last), 0);
      sum += max(0.0, 1.0 - abs(other.b - middle.b) * narrow) * vec3(other.rg, 1.0);
    }
  color = vec4(sum.rg / sum.b, middle.b, 1.0);
}
