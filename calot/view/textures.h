// The tissue's textures, made by the program: seamless, seeded, the same bytes everywhere. The shader that reads them
// is shaders/tissue.glsl.
#pragma once
#include <cstdint>
#include <vector>

namespace calot {

/// Texels of 4 bytes, x fastest, then y, then z; the last texel of each axis is followed by the first.
struct TextureBytes {
  int size = 0;   ///< along x and y
  int depth = 1;  ///< along z: 1 or `size`
  std::vector<std::uint8_t> rgba;
};

/// Solid noise of `size`³ texels, size 16 … 256. Red: lobules, 0 on their borders, 1 inside, 9 along the tile. Green:
/// larger lobules as pillows, 4 along the tile. Blue: clouds of four octaves, mean ½. Alpha: strands, thin curved films
/// seen as lines.
TextureBytes make_tissue_volume(int size = 128);

/// Vessels, 512². Red: trees that branch from wide to fine. Green: a network of finer ones. Blue: the flush around
/// both. Alpha: fine grain, mean ½.
TextureBytes make_vessel_tile();

/// The textures on the graphics card. Needs a current OpenGL 3.3 context, when made, bound and destroyed.
class TissueTextures {
 public:
  /// @param lite  a smaller volume, and the nearest of the copies for distance instead of two blended: less time
  explicit TissueTextures(bool lite);
  ~TissueTextures();
  TissueTextures(const TissueTextures&) = delete;
  TissueTextures& operator=(const TissueTextures&) = delete;

  static constexpr int first_unit = 5;  ///< texture units 5 and 6: tissue_noise and tissue_detail in the shaders

  /// Binds both textures to their units; before draws.
  void bind() const;

 private:
  unsigned volume_ = 0, vessels_ = 0;
};

}  // namespace calot
