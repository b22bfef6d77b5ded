// The last pass of `full`: edges smoothed along their direction (after the idea of FXAA [Lottes2009]), the lens's barrel
// and colour fringes, and the soft rim of the round field.
#include "frame.glsl"
#include "tone.glsl"
uniform sampler2D color_map;
in vec2 at;
out vec4 color;

vec3 smoothed(vec2 p) {
  vec2 t = viewport.zw;
  vec4 middle = texture(color_map, p);
  float nw = texture(color_map, p + vec2(-t.x, t.y)).a, ne = texture(color_map, p + t).a;
  float sw = texture(color_map, p - t).a, se = texture(color_map, p + vec2(t.x, -t.y)).a;
  float low = min(middle.a, min(min(nw, ne), min(sw, se)));
  float high = max(middle.a, max(max(nw, ne), max(sw, se)));
  if (high - low < max(0.04, 0.11 * high)) return middle.rgb;
  vec2 along = vec2((sw + se) - (nw + ne), (nw + sw) - (ne + se));
  float shortest = 1.0 / (min(abs(along.x), abs(along.y)) + max(0.03 * (nw + ne + sw + se), 0.008));
  along = clamp(along * shortest, -6.0, 6.0) * t;
  vec4 near = 0.5 * (texture(color_map, p - along / 6.0) + texture(color_map, p + along / 6.0));
  vec4 far = 0.5 * near + 0.25 * (texture(color_map, p - 0.5 * along) + texture(color_map, p + 0.5 * along));
  return far.a < low || far.a > high ? near.rgb : far.rgb;
}

void main() {
  vec2 from_middle = (at - 0.5) * viewport.xy * scope.y;  // in radii of the field
  float r2 = dot(from_middle, from_middle);
  float barrel = (1.0 + scope.z * r2) / (1.0 + scope.z);
  vec2 place = 0.5 + (at - 0.5) * barrel;
  vec3 seen = smoothed(place);
  float fringe = scope.w * r2;
  seen.r = mix(seen.r, texture(color_map, 0.5 + (place - 0.5) * (1.0 - fringe)).r, 0.7);
  seen.b = mix(seen.b, texture(color_map, 0.5 + (place - 0.5) * (1.0 + fringe)).b, 0.7);
  color = vec4(seen * field_edge(sqrt(r2)), 1.0);
}
