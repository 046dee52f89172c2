// What MP4 and QuickTime files say of their film.
#include "core/io/pictures/movie_header.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  const auto film = fuzz::Put("film.mp4", fuzz::Bytes(data, size));
  IsMovie(film);
  return fuzz::Expect([&] { ReadMovieHeader(film); });
}
