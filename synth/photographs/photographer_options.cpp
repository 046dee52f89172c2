#include "synth/photographs/photographer_options.h"

#include "core/values/size_of.h"

namespace keypose::synth {

std::vector<std::string> PhotographerOptions::Problems() const {
  std::vector<std::string> problems;
  const auto require = [&](bool good, const char* text) {
    if (!good) problems.emplace_back(text);
  };
  require(!elevations_deg.empty() && elevations_deg.size() <= 20,
          "elevations_deg needs 1 to 20 rings");
  for (const double e : elevations_deg)
    require(e > -10 && e < 85, "elevations_deg must be in (-10, 85)");
  require(views >= SizeOf(elevations_deg) && views <= 2000,
          "views must be at least one per ring and at most 2000");
  require(width >= 32 && height >= 32 && width <= 10000 && height <= 10000,
          "width and height must be in [32, 10000] px");
  require(focal_35mm >= 15 && focal_35mm <= 400, "focal_35mm must be in [15, 400] mm");
  require(fill > 0.05 && fill <= 1, "fill must be in (0.05, 1]");
  require(background == "studio" || background == "plain", "background can be studio or plain");
  require(noise >= 0 && blur_px >= 0 && blur_px < 20 && vignetting >= 0 && vignetting < 1,
          "noise and blur_px must be >= 0, vignetting in [0, 1)");
  require(supersampling >= 1 && supersampling <= 8, "supersampling must be in [1, 8]");
  require(enlarge >= 1 && enlarge <= 8 && width % enlarge == 0 && height % enlarge == 0,
          "enlarge must be in [1, 8] and divide width and height");
  require(table_shadow >= 0 && table_shadow <= 1, "table_shadow must be in [0, 1]");
  require(ambient >= 0 && lamp >= 0 && gloss >= 0, "ambient, lamp and gloss must be >= 0");
  for (const std::string& problem : mishaps.Problems(views)) problems.push_back(problem);
  return problems;
}

}  // namespace keypose::synth
