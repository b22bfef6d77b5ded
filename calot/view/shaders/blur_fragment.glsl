// Smooths the ambient map over the four-by-four pattern of its samples, not across edges in depth.
#include "frame.glsl"
uniform sampler2D color_map;
uniform sampler2D depth_map;
in vec2 at;
out vec4 color;

void main() {
  vec2 texel = 1.0 / vec2(textureSize(color_map, 0));
  float middle = view_depth(texture(depth_map, at).r), sum = 0.0, weights = 0.0;
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x) {
      vec2 p = at + 1.34 * vec2(x, y) * texel;
      float weight = max(0.02, 1.0 - abs(view_depth(texture(depth_map, p).r) - middle) * 400.0);
      sum += weight * texture(color_map, p).r;
      weights += weight;
    }
  color = vec4(sum / weights);
}
