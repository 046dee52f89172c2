// keypose-synth: worlds with known truth. Photographs, simulated picks, scores, and damage for tests.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "core/errors.h"
#include "synth/photos_command.h"

namespace {

using namespace keypose;
using namespace keypose::synth;

class ConsoleProgress final : public Progress {
 public:
  void Update(double fraction, std::string_view what) override {
    std::fprintf(stderr, "synth: %3.0f %% %.*s\n", 100 * fraction, static_cast<int>(what.size()), what.data());
  }
};

void AddPhotos(CLI::App& app, PhotosCommand& c) {
  CLI::App* photos = app.add_subcommand("photos", "render turntable photographs of a clay character, with exact truth beside them");
  photos->add_option("--output", c.output, "folder to write photos/ and truth/ into")->required();
  photos->add_option("--poses", c.poses, "rest, bent, wave, bow, squash, twist")->delimiter(',')->capture_default_str();
  photos->add_option("--seed", c.world.seed, "character; 1 is the demo's")->capture_default_str();
  photos->add_option("--texture", c.world.texture, "rich | weak")->capture_default_str();
  photos->add_option("--spacing", c.world.spacing_m, "of the true surface's vertices, about [m]")->capture_default_str();
  photos->add_option("--views", c.photographer.views, "photographs a pose, over all rings")->capture_default_str();
  photos->add_option("--elevations", c.photographer.elevations_deg, "one ring each [deg]")->delimiter(',')->capture_default_str();
  photos->add_option("--width", c.photographer.width, "[px]")->capture_default_str();
  photos->add_option("--height", c.photographer.height, "[px]; 3/4 of the width when only that is given")->capture_default_str();
  photos->add_option("--focal", c.photographer.focal_35mm, "35 mm equivalent [mm]")->capture_default_str();
  photos->add_option("--noise", c.photographer.noise, "sensor noise, 1 is ordinary")->capture_default_str();
  photos->add_option("--blur", c.photographer.blur_px, "standard deviation of the lens blur [px]")->capture_default_str();
  photos->add_option("--vignetting", c.photographer.vignetting, "light lost in the corners")->capture_default_str();
  photos->add_option("--backdrop", c.photographer.background, "studio | plain")->capture_default_str();
  photos->add_flag("!--no-shadows", c.photographer.shadows, "light that nothing blocks");
  photos->add_flag("--charuco", c.photographer.plate.charuco, "a ChArUco plate under the character");
  photos->add_flag("--background-plate", c.background_plate, "also photograph the empty set");
  photos->add_option("--photographer-seed", c.photographer.seed, "of jitter and noise")->capture_default_str();
  photos->callback([photos, &c] {
    if (photos->count("--width") && !photos->count("--height")) c.photographer.height = c.photographer.width * 3 / 4;
    ConsoleProgress progress;
    std::printf("%d photographs in %s\n", RunPhotos(c, &progress), (c.output / "photos").c_str());
  });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Synthetic worlds with known truth", "keypose-synth");
  app.require_subcommand(1);
  PhotosCommand photos;
  AddPhotos(app, photos);
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& fault) {
    app.exit(fault);
    return static_cast<int>(ExitCode::kUsage);
  } catch (const Error& fault) {
    std::fprintf(stderr, "%s\n", fault.what());
    return static_cast<int>(fault.code());
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "synth: a bug: %s\n", fault.what());
    return static_cast<int>(ExitCode::kBug);
  }
}
