// The recipes of tissue.glsl, one for each look outside and on a cut face. LOOK and CUT are constants of a program, so the
// compiler keeps one recipe and drops what it doesn't use. Numbers of the enum TissueLook (calot/view/snapshot.h).
#define SOFT 0
#define LIVER 1
#define GALLBLADDER 2
#define DUCT 3
#define ARTERY 4
#define FAT 5
#define BED 6
#define PERITONEUM 7

struct Recipe {
  vec3 low, high;       // colours that the pattern goes between, as on a screen (sRGB)
  vec4 pattern;         // weights of lobules, pillows, clouds, strands
  float bias;           // the pattern where all of them are at 1/2
  vec3 patch_color;     // of large patches
  float patches;        // how strong they are, 0 ... 1
  vec3 mark;            // colour of vessels, tubes and strands
  vec3 vessels;         // strength of wide ones, fine ones, the flush around them
  float ducts, strands;  // strength of tubes seen end on, and of strands
  vec3 stretch;         // of the noise along its own axes
  float tile, large;    // width of the noise's tile for detail and for patches [mm]
  vec4 relief;          // of lobules, pillows, clouds, strands [mm]
  float grain;          // fine relief [mm]
  float roughness, coat, coat_roughness;
  vec3 subsurface;
};

Recipe outside_recipe(int look) {
  Recipe r;
  r.low = vec3(0.57, 0.31, 0.26), r.high = vec3(0.70, 0.43, 0.36);
  r.pattern = vec4(0.2, 0.0, 0.9, 0.0), r.bias = 0.5;
  r.patch_color = vec3(0.65, 0.44, 0.32), r.patches = 0.5;
  r.mark = vec3(0.59, 0.22, 0.21), r.vessels = vec3(0.35, 0.4, 0.2), r.ducts = 0.0, r.strands = 0.0;
  r.stretch = vec3(1.0), r.tile = 18.0, r.large = 67.0;
  r.relief = vec4(0.01, 0.0, 0.10, 0.01), r.grain = 0.005;
  r.roughness = 0.52, r.coat = 0.7, r.coat_roughness = 0.24, r.subsurface = vec3(0.35, 0.15, 0.12);
  if (look == LIVER) {
    r.low = vec3(0.36, 0.155, 0.12), r.high = vec3(0.53, 0.265, 0.205);
    r.pattern = vec4(0.13, 0.10, 0.85, 0.0);
    r.patch_color = vec3(0.45, 0.235, 0.165);
    r.vessels = vec3(0.0);
    r.tile = 13.0, r.large = 71.0;
    r.relief = vec4(0.0, 0.0, 0.08, 0.0), r.grain = 0.0;
    r.roughness = 0.55, r.coat = 0.65, r.coat_roughness = 0.28, r.subsurface = vec3(0.22, 0.06, 0.04);
  } else if (look == GALLBLADDER) {
    r.low = vec3(0.39, 0.45, 0.345), r.high = vec3(0.56, 0.61, 0.51);
    r.pattern = vec4(0.0, 0.0, 1.1, 0.15), r.bias = 0.45;
    r.patch_color = vec3(0.47, 0.495, 0.28), r.patches = 0.6;
    r.mark = vec3(0.50, 0.17, 0.18), r.vessels = vec3(0.75, 0.5, 0.25);
    r.tile = 21.0, r.large = 83.0;
    r.relief = vec4(0.0, 0.0, 0.10, 0.02), r.grain = 0.006;
    r.roughness = 0.5, r.coat = 0.8, r.coat_roughness = 0.22, r.subsurface = vec3(0.28, 0.32, 0.16);
  } else if (look == DUCT) {
    r.low = vec3(0.64, 0.56, 0.38), r.high = vec3(0.79, 0.71, 0.55);
    r.pattern = vec4(0.0, 0.0, 1.0, 0.2);
    r.patch_color = vec3(0.64, 0.60, 0.36), r.patches = 0.4;
    r.mark = vec3(0.62, 0.25, 0.22), r.vessels = vec3(0.35, 0.7, 0.2);
    r.tile = 12.0, r.large = 37.0;
    r.relief = vec4(0.0, 0.0, 0.08, 0.02);
    r.coat = 0.75, r.coat_roughness = 0.22, r.subsurface = vec3(0.35, 0.28, 0.15);
  } else if (look == ARTERY) {
    r.low = vec3(0.70, 0.32, 0.30), r.high = vec3(0.81, 0.46, 0.42);
    r.pattern = vec4(0.0, 0.0, 0.9, 0.2);
    r.patch_color = vec3(0.79, 0.54, 0.47), r.patches = 0.4;
    r.mark = vec3(0.59, 0.16, 0.16), r.vessels = vec3(0.2, 0.5, 0.2);
    r.tile = 10.0, r.large = 23.0;
    r.relief = vec4(0.0, 0.0, 0.05, 0.01), r.grain = 0.003;
    r.roughness = 0.42, r.coat = 0.95, r.coat_roughness = 0.16, r.subsurface = vec3(0.40, 0.12, 0.10);
  } else if (look == FAT) {
    r.low = vec3(0.80, 0.53, 0.31), r.high = vec3(0.91, 0.75, 0.45);
    r.pattern = vec4(0.0, 0.65, 0.55, 0.0), r.bias = 0.55;
    r.patch_color = vec3(0.89, 0.69, 0.38);
    r.mark = vec3(0.67, 0.24, 0.19), r.vessels = vec3(0.35, 0.35, 0.15);
    r.tile = 14.0, r.large = 59.0;
    r.relief = vec4(0.0, 0.36, 0.10, 0.0), r.grain = 0.004;
    r.roughness = 0.5, r.coat = 0.65, r.coat_roughness = 0.28, r.subsurface = vec3(0.45, 0.33, 0.15);
  } else if (look == BED) {
    r.low = vec3(0.44, 0.165, 0.145), r.high = vec3(0.565, 0.275, 0.235);
    r.pattern = vec4(0.0, 0.0, 1.0, 0.3), r.bias = 0.45;
    r.patch_color = vec3(0.62, 0.41, 0.355), r.patches = 0.4;
    r.mark = vec3(0.85, 0.76, 0.70), r.vessels = vec3(0.0), r.strands = 0.6;
    r.stretch = vec3(1.0, 0.7, 0.3), r.tile = 11.0, r.large = 47.0;
    r.relief = vec4(0.0, 0.1, 0.12, 0.12), r.grain = 0.0;
    r.roughness = 0.6, r.coat = 0.65, r.coat_roughness = 0.28, r.subsurface = vec3(0.35, 0.18, 0.15);
  } else if (look == PERITONEUM) {
    r.low = vec3(0.70, 0.46, 0.41), r.high = vec3(0.81, 0.59, 0.53);
    r.pattern = vec4(0.0, 0.0, 1.0, 0.0);
    r.patch_color = vec3(0.77, 0.57, 0.44);
    r.mark = vec3(0.64, 0.26, 0.26), r.vessels = vec3(0.5, 0.4, 0.3);
    r.tile = 24.0, r.large = 97.0;
    r.relief = vec4(0.0, 0.0, 0.06, 0.01), r.grain = 0.004;
    r.roughness = 0.5, r.coat = 0.7, r.coat_roughness = 0.22, r.subsurface = vec3(0.38, 0.20, 0.17);
  }
  return r;
}

Recipe cut_recipe(int look) {
  Recipe r = outside_recipe(look);
  r.vessels = vec3(0.0);
  if (look == LIVER) {
    r.low = vec3(0.27, 0.07, 0.06), r.high = vec3(0.45, 0.155, 0.12), r.pattern = vec4(0.4, 0.0, 0.9, 0.0);
    r.patch_color = vec3(0.34, 0.08, 0.06), r.mark = vec3(0.62, 0.36, 0.27), r.ducts = 0.6;
    r.tile = 11.0, r.large = 29.0, r.relief = vec4(0.03, 0.02, 0.12, 0.02), r.grain = 0.04;
    r.coat = 0.9, r.coat_roughness = 0.22;
  } else if (look == GALLBLADDER) {
    r.low = vec3(0.38, 0.39, 0.15), r.high = vec3(0.57, 0.55, 0.25), r.pattern = vec4(0.45, 0.0, 0.8, 0.0);
    r.patch_color = vec3(0.47, 0.41, 0.12), r.mark = vec3(0.77, 0.71, 0.51), r.strands = 0.35;
    r.tile = 5.0, r.large = 31.0, r.relief = vec4(0.02, 0.0, 0.05, 0.01), r.grain = 0.02;
    r.coat = 0.55, r.coat_roughness = 0.36;
  } else if (look == DUCT) {
    r.low = vec3(0.56, 0.50, 0.22), r.high = vec3(0.84, 0.77, 0.60), r.pattern = vec4(0.0, 0.4, 1.6, 0.2), r.bias = 0.55;
    r.patches = 0.3, r.tile = 9.0, r.relief = vec4(0.02, 0.0, 0.06, 0.03);
  } else if (look == ARTERY) {
    r.low = vec3(0.55, 0.12, 0.11), r.high = vec3(0.84, 0.55, 0.48), r.pattern = vec4(0.0, 0.4, 1.6, 0.2), r.bias = 0.6;
    r.patches = 0.3, r.tile = 7.0, r.relief = vec4(0.02, 0.0, 0.05, 0.02);
  } else if (look == FAT) {
    r.low = vec3(0.82, 0.60, 0.27), r.high = vec3(0.94, 0.81, 0.49), r.pattern = vec4(0.45, 0.4, 0.4, 0.0);
    r.tile = 10.0, r.relief = vec4(0.06, 0.20, 0.08, 0.0), r.grain = 0.02;
  } else if (look == BED) {
    r.low = vec3(0.46, 0.14, 0.13), r.strands = 0.6, r.grain = 0.02;
  } else {
    r.low = vec3(0.52, 0.19, 0.17), r.high = vec3(0.70, 0.36, 0.31), r.mark = vec3(0.82, 0.66, 0.58), r.strands = 0.3;
    r.stretch = vec3(1.0, 1.0, 0.4), r.tile = 9.0, r.relief = vec4(0.03, 0.0, 0.08, 0.05), r.grain = 0.02;
  }
  return r;
}
