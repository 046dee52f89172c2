// All pictures of a film of 1920 x 1080 as RGB, beside the ffmpeg program that does the same.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/testing/folder.h"
#include "views/decode/film_decoder.h"

namespace {

using namespace keypose;

void Shell(const std::string& command) {
  if (std::system(command.c_str()) != 0) throw std::runtime_error("failed: " + command);
}

/// 150 pictures of H.264 with moving shapes and the noise of a camera.
class Film : public TestingFolder {
 public:
  Film() {
    Shell(
        "ffmpeg -v error -f lavfi -i testsrc2=size=1920x1080:rate=30:duration=5 -vf "
        "noise=alls=6:allf=t -pix_fmt yuv420p -c:v libx264 -preset veryfast -crf 20 " +
        file());
  }
  std::string file() const { return (path() / "film.mp4").string(); }
};
const Film& TheFilm() {
  static const Film film;
  return film;
}

void Keypose(benchmark::State& state) {
  const std::string file = TheFilm().file();
  for (auto _ : state) {
    FilmDecoder decoder(file, std::make_shared<FilmIndex>(ReadFilmIndex(file)));
    for (int picture = 0; picture < decoder.index().frames(); ++picture)
      benchmark::DoNotOptimize(decoder.Read(picture, 3).data.data());
  }
}

/// Its colours by the film's matrix with full accuracy of chroma, as ours are; its defaults are
/// BT.601 and the nearest colour.
void Ffmpeg(benchmark::State& state) {
  const std::string command = "ffmpeg -v error -y -i " + TheFilm().file();
  const bool exact = state.range(0) != 0;
  for (auto _ : state)
    Shell(command +
          (exact ? " -sws_flags bilinear+accurate_rnd+full_chroma_int+full_chroma_inp" : "") +
          " -f rawvideo -pix_fmt rgb24 /dev/null");
}
BENCHMARK(Keypose)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(Ffmpeg)->Unit(benchmark::kMillisecond)->Arg(0)->Arg(1)->UseRealTime();

}  // namespace
