#pragma once

#include <cstdint>
#include <vector>

#include "renderer/film/tile.h"
#include "renderer/render/sample_tracer.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// Light that the samples of a block of pixels (kBlockSide) may have missed. A block whose samples
/// are all alike tells nothing of it; the rest of the picture does.
///
/// Some blocks of the frame are looked at first. The light that samples missed in blocks that met
/// nothing rare is about what samples met once in the others (Robbins 1956, "An empirical Bayes
/// approach to statistics": of Poisson counts of unknown rates, the mean rate of those that are 0
/// is the number of those that are 1 over the number of those that are 0). And of emissive shapes
/// smaller than a pixel the camera tells where they are and how many samples miss them.
///
/// A pure function of the scene, so that the frame may be cut in any way. Immutable.
class HiddenLight {
 public:
  /// Samples blocks of the frame, each pixel as often as the first look at a block does.
  HiddenLight(const Scene& scene, const SampleTracer& tracer);

  /// The mean square error of the pixels of the block that has this pixel, from what `samples` of
  /// each of its `pixels` may have missed; of a pixel that it makes brighter than display white in
  /// proportion to that.
  double square_error(int x, int y, int pixels, uint32_t samples) const;

 private:
  struct Speck {
    int block = 0;
    double pixels = 0;    ///< that it covers, less than one
    double radiance = 0;  ///< of its brightest channel
  };
  int block_of(int x, int y) const;
  void look_at_blocks(const Scene& scene, const SampleTracer& tracer);
  void find_specks(const Scene& scene);

  int blocks_across_;
  double met_nothing_ = 0;     ///< how many of the blocks looked at met nothing rare
  std::vector<double> rare_;   ///< squares of what the others met once, means over the channels
  std::vector<Speck> specks_;  ///< by block
};

}  // namespace tessera
