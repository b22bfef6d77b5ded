// Light on a surface: the endoscope's lamp, and what the cavity gives back.
uniform sampler2DShadow shadow_map;
uniform sampler2D shadow_depth;  // the same map, as it is

const float pi = 3.14159265;

// GGX [Walter2007] times the height-correlated Smith term in the approximation of [Hammon2017].
float specular_term(float alpha, float n_h, float n_l, float n_v) {
  float a2 = alpha * alpha;
  float d = (n_h * a2 - n_h) * n_h + 1.0;
  float visible = 0.5 / max(mix(2.0 * n_l * n_v, n_l + n_v, alpha), 1e-4);
  return a2 / (pi * d * d) * visible;
}

// Schlick's fifth power [Schlick1994].
float schlick(float v_h) {
  float m = 1.0 - v_h;
  float m2 = m * m;
  return m2 * m2 * m;
}

// A number 0 ... 1 that differs from pixel to pixel without clumps [Jimenez2014].
float pixel_noise(vec2 pixel) { return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))); }

// Share of the lamp that reaches a point. LAMP_KNOWN: it was found for all pixels in a pass of its own (lamp_share). SOFT:
// the lamp is as wide as it is: what blocks it is looked for first, and the farther that is off, the softer the shadow's
// edge [Fernando2005]. Else one smoothed look into its map.
#ifdef LAMP_KNOWN
float lamp_share = 1.0;
float lamp_visibility(vec3 position, vec3 normal, float distance) { return lamp_share; }
#else
float lamp_visibility(vec3 position, vec3 normal, float distance) {
  vec4 place = light_view_projection * vec4(position + normal * distance * ambient.w * 1.5, 1.0);
  vec3 at = place.xyz / place.w * 0.5 + 0.5;
#ifndef SOFT
  return texture(shadow_map, at);
#else
  const float lamp_radius = 0.0022;  // [m]
  float turn = 6.2831853 * pixel_noise(floor(gl_FragCoord.xy));
  vec2 x = vec2(cos(turn), sin(turn)), y = vec2(-x.y, x.x);
  float here = place.w, scale = 0.42;  // of the map's width to the slope of a ray: 1 / (2 tan(field / 2))
  float widest = lamp_radius * scale / 0.04;
  float blockers = 0.0, depth = 0.0;
  for (int i = 0; i < 5; ++i) {
    float angle = 2.3999632 * float(i), radius = widest * sqrt((float(i) + 0.4) / 5.0);
    float seen = view_depth(texture(shadow_depth, at.xy + radius * (cos(angle) * x + sin(angle) * y)).r);
    float blocks = step(seen, here - 0.0006);
    blockers += blocks;
    depth += blocks * seen;
  }
  if (blockers < 0.5) return 1.0;
  depth /= blockers;
  float radius = clamp(lamp_radius * (here - depth) / (depth * here) * scale, 0.75 * ambient.w, widest);
  float sum = 0.0;
  for (int i = 0; i < 6; ++i) {
    float angle = 2.3999632 * float(i) + 1.0, r = radius * sqrt((float(i) + 0.5) / 6.0);
    sum += texture(shadow_map, vec3(at.xy + r * (cos(angle) * x + sin(angle) * y), at.z));
  }
  return sum / 6.0;
#endif
}
#endif

// The lamp's power at a squared distance: its end and the lens before it have some width.
float lamp_power(float d2) { return light.w / (d2 + 0.0003); }

// The lamp's light by direction: bright in the middle of the field, less towards its edge.
float lamp_cone(float cosine) {
  float edge = clamp((cosine - 0.60) / 0.40, 0.0, 1.0);
  return 0.12 + 0.88 * edge * edge * (3.0 - 2.0 * edge);
}

// What a mirror sees that looks along `ray`: lit tissue ahead, little behind the camera.
vec3 cavity(vec3 ray) {
  float ahead = dot(ray, forward.xyz);
  return ambient.rgb * (0.15 + 4.5 * smoothstep(-0.35, 0.95, ahead));
}

vec3 shade(Material m, vec3 n, vec3 position, vec3 smooth_normal, float open) {
  vec3 to_eye = eye.xyz - position;
  vec3 v = normalize(to_eye);
  vec3 to_light = light.xyz - position;
  float d2 = dot(to_light, to_light);
  float distance = sqrt(d2);
  vec3 l = to_light / distance;
  vec3 h = normalize(l + v);
  float n_l_raw = dot(n, l);
  float n_l = max(n_l_raw, 0.0);
  float n_v = max(dot(n, v), 0.05);
  float n_h = max(dot(n, h), 0.0);
  float v_h = max(dot(v, h), 0.0);
  float lamp = lamp_power(d2) * lamp_cone(dot(-l, light_axis.xyz)) * lamp_visibility(position, smooth_normal, distance);
  open *= m.ao;

  // Wrapped diffuse light that gives back no more than it gets [McAuley2011]; wider in red, so that edges glow.
  vec3 wrap = m.subsurface;
  vec3 wrapped = max(vec3(0.0), (n_l_raw + wrap) / ((1.0 + wrap) * (1.0 + wrap)));
  float widening = 0.0015 / distance;  // the lamp's end is about 3 mm wide [Karis2013]
  float rough = clamp(m.roughness * m.roughness + widening, 0.003, 1.0);
  vec3 f0 = mix(vec3(0.028), m.base, m.metal);
  float fresnel = schlick(v_h);
  vec3 f = f0 + (1.0 - f0) * fresnel;
  vec3 diffuse = m.base * (1.0 - m.metal) * (1.0 - f) * wrapped / pi;
  vec3 direct = diffuse + f * specular_term(rough, n_h, n_l, n_v) * n_l;

  float grazing = schlick(n_v);
  vec3 bounced = ambient.rgb * open;
  vec3 indirect = m.base * (1.0 - m.metal) * bounced;
  vec3 mirrored = cavity(reflect(-v, n)) * open;
  float smooth_share = (1.0 - m.roughness) * (1.0 - m.roughness);
  indirect += mirrored * (f0 + (1.0 - f0) * 0.5 * smooth_share * grazing);

  // The wet film lies over all of it.
  float film = m.coat * (0.025 + 0.975 * fresnel);
  float film_rough = clamp(m.coat_roughness * m.coat_roughness + widening, 0.003, 1.0);
  vec3 color = (direct * lamp * pi + indirect) * (1.0 - film);
  color += film * specular_term(film_rough, n_h, n_l, n_v) * n_l * lamp * pi;
  color += mirrored * m.coat * (0.02 + (1.0 - m.coat_roughness) * 0.16 * grazing);
  return color;
}
