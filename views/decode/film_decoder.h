// Pictures of a film, in order or by their times.
#pragma once

#include <filesystem>
#include <memory>

#include "core/values/image.h"
#include "core/values/progress.h"
#include "views/decode/film_index.h"

namespace keypose {

/// As OpenCV's cvtColor weighs, in whole numbers: what masks and pictures read as luma have.
/// @param colors  RGB, with or without alpha
Image8 FilmLuma(const Image8& colors);

/// Reading in order is fast; a film is decoded anew from its start when an earlier picture is asked
/// for. Pictures are upright, and their colours are RGB of 8 bits as players show them. Not for use
/// in several threads at once.
class FilmDecoder {
 public:
  /// @param index  of this file
  FilmDecoder(std::filesystem::path path, std::shared_ptr<const FilmIndex> index);
  ~FilmDecoder();
  FilmDecoder(FilmDecoder&&) noexcept;
  FilmDecoder& operator=(FilmDecoder&&) noexcept;

  const FilmIndex& index() const;

  /// @param picture   counted from 0; index().PictureAt tells which one is shown at a time
  /// @param channels  1 (luma), 3 (RGB) or 4 (RGB and alpha; 255 where the film has none)
  /// @param progress  asked for cancel before each picture that is decoded; may be null
  /// @throws InputError  it cannot be decoded; names the file, the picture and its time
  /// @throws UsageError  no such picture
  Image8 Read(int picture, int channels, const Progress* progress = nullptr);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace keypose
