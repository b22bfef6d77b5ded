// Tissue (TISSUE, LOOK, CUT, MASK), instruments (INSTRUMENT) and the cavity's wall (CAVITY) under the lamp. LITE: the
// final colour at once; else light for the passes that follow.
#ifndef LITE
#define LAMP_KNOWN
#endif
#include "frame.glsl"
#include "material.glsl"
#include "light.glsl"
#include "tone.glsl"
#include "bump.glsl"
#include "noise.glsl"
#include "smoke.glsl"
#ifdef TISSUE
#include "tissue.glsl"
in vec4 condition;
in vec3 rest, rest_normal;
#ifdef MASK
uniform sampler3D mask_volume;
uniform vec3 mask_origin, mask_scale;
#endif
#endif
#ifdef INSTRUMENT
#include "metal.glsl"
uniform int substance;
in vec3 own_position, own_grain, grain;
in float openness;
#endif
#ifdef CAVITY
#include "cavity.glsl"
#endif
in vec3 position, normal;
#ifndef LITE
uniform sampler2D ambient_map;
#endif
out vec4 color;

#ifndef INSTRUMENT
Material material_here(vec3 n) {
#ifdef TISSUE
#ifdef MASK
  vec4 mask = texture(mask_volume, (rest - mask_origin) * mask_scale);
#else
  vec4 mask = vec4(0.0);
#endif
#ifdef LITE
  return tissue(LOOK, CUT, rest, normalize(rest_normal), condition, mask, true);
#else
  return tissue(LOOK, CUT, rest, normalize(rest_normal), condition, mask, false);
#endif
#else
  return cavity_wall(position, n);
#endif
}
#endif

// Light that comes from here to the eye; `open`: how much of the surroundings is seen from here.
vec3 light_here(float open) {
  vec3 n = normalize(normal);
  if (!gl_FrontFacing) n = -n;
#ifdef INSTRUMENT
  return metal_light(substance, n, position, normalize(grain), own_position, own_grain, open * openness);
#else
  Material m = material_here(n);
  return shade(m, bumped(position, n, m.height), position, n, open);
#endif
}

#ifndef LITE
// From the map of half the size: of the four nearest, those that lie on this surface.
vec2 ambient_and_lamp() {
  vec2 at = gl_FragCoord.xy * 0.5 - 0.5;
  ivec2 corner = ivec2(floor(at)), last = textureSize(ambient_map, 0) - 1;
  vec2 f = at - vec2(corner);
  float depth = dot(position - eye.xyz, forward.xyz);
  vec3 sum = vec3(0.0);
  for (int k = 0; k < 4; ++k) {
    ivec2 step_to = ivec2(k & 1, k >> 1);
    vec4 known = texelFetch(ambient_map, clamp(corner + step_to, ivec2(0), last), 0);
    vec2 share = mix(1.0 - f, f, vec2(step_to));
    float weight = (share.x * share.y + 0.001) * max(0.0005, 1.0 - abs(known.b - depth) * 400.0);
    sum += weight * vec3(known.rg, 1.0);
  }
  return sum.rg / sum.b;
}
#endif

void main() {
#ifdef LITE
  float radius = length(gl_FragCoord.xy - 0.5 * viewport.xy) * scope.y;
  color = vec4(screen_value(tone_curve(through_haze(light_here(1.0), gas.x, distance(position, eye.xyz)) * eye.w)) * field_edge(radius), 1.0);
#else
  vec2 known = ambient_and_lamp();
  float open = known.x;
  lamp_share = known.y;
  color = vec4(min(through_haze(light_here(open), gas.x, distance(position, eye.xyz)) * eye.w, vec3(200.0)), 1.0);
#endif
}
