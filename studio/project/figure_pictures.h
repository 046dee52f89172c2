// The pictures in which a person says what the figure is: a pose's photographs, or the frames of a
// shot's films. For figure.cpp.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/values/figure_strokes.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

class FigurePictures {
 public:
  virtual ~FigurePictures() = default;
  /// As the page shows it (figure.h).
  virtual nlohmann::json JsonOf(const FigureStroke& stroke) const = 0;
  /// @throws UsageError  no such picture, or a place outside of it
  virtual FigureStroke StrokeOf(const nlohmann::json& one) const = 0;
};

/// @param pose  or shot
std::unique_ptr<FigurePictures> PicturesOfFigure(Snapshot& snapshot, const std::string& pose);

}  // namespace keypose::studio
