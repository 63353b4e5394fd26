// Prints the numbers of renderer/shading/glass_walks.cpp, which takes a quarter of an hour:
//   ninja -C build/release glass_walks && build/release/bin/glass_walks
#include "renderer/shading/glass_walks.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "tests/smith_walk.h"

int main(int count, char** words) {
  using tessera::GlassWalks;
  const int walks = count > 1 ? std::atoi(words[1]) : 250'000;
  for (int inside = 0; inside < 2; ++inside) {
    for (int index = 1; index < GlassWalks::kIndices; ++index) {
      const double n = GlassWalks::index_at(index);
      for (int alpha = 0; alpha < GlassWalks::kAlphas; ++alpha) {
        const double root = std::max(GlassWalks::root_alpha_at(alpha), 0.02);
        for (int cosine = 0; cosine < GlassWalks::kCosines; ++cosine) {
          const double c = std::max(GlassWalks::root_cosine_at(cosine), 0.01);
          tessera::SmithWalk walk(inside != 0 ? 1 / n : n, root * root, 1);
          const tessera::GlassShares shares = walk.shares(c * c, walks);
          const double all = shares.back + shares.through;
          std::printf("%d,%s", all > 0 ? static_cast<int>(1e4 * shares.back / all + 0.5) : 0,
                      cosine + 1 == GlassWalks::kCosines ? "\n" : " ");
          std::fflush(stdout);
        }
      }
    }
  }
}
