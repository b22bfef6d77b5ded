// Tissue (TISSUE, LOOK, CUT, MASK), instruments (INSTRUMENT) and the cavity's wall (CAVITY) under the lamp. LITE: the
// final colour at once; else light for the passes that follow.
#include "frame.glsl"
#include "material.glsl"
#include "light.glsl"
#include "tone.glsl"
#include "bump.glsl"
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

void main() {
#ifdef LITE
  float radius = length(gl_FragCoord.xy - 0.5 * viewport.xy) * scope.y;
  color = vec4(screen_value(tone_curve(light_here(1.0) * eye.w)) * field_edge(radius), 1.0);
#else
  float open = texture(ambient_map, gl_FragCoord.xy * viewport.zw).r;
  color = vec4(min(light_here(open) * eye.w, vec3(200.0)), 1.0);
#endif
}
