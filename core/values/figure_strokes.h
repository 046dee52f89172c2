// What a person said about what the figure is: clicks and strokes in photographs or filmed frames,
// as one text, which is the option `figure` of the stages `masks`, `capture` and `silhouettes`.
//
//     IMG_0012.jpg:512,300                       a click
//     IMG_0012.jpg:512,300-530,340-540,420       a stroke
//     !IMG_0007.jpg:40,900                       this is not the figure
//     cam2/114:640,200                           of a film: camera, and frame from 0
//
// Several stand one after the other, with a space or ';' between them. A photograph's name may have
// spaces. The characters % ; : of a name, a '!' or space at its begin or end, and control
// characters are written as %25, %3B, %3A, ... Pixels are those of the picture as a viewer shows
// it, upright: the origin is its upper left corner, x to the right, y down, and the first pixel's
// centre is (0.5, 0.5).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace keypose {

/// The option `figure`, for the stages' help.
inline constexpr const char* kFigureHelp =
    "what a person said the figure is, which `keypose figure` writes: clicks PICTURE:X,Y or lines "
    "PICTURE:X,Y-X,Y..., separated by spaces; ! before one: this is not the figure";

struct FigureStroke {
  /// a photograph, as its path below the pose's folder: IMG_0012.jpg, lying/IMG_0012.jpg; of a film
  /// CAMERA/FRAME
  std::string picture;
  std::vector<Eigen::Vector2d> points;  ///< [px], of the upright picture; one: a click
  bool figure = true;                   ///< false: what lies there is not the figure
};

/// @throws UsageError  the text is not of that form, or has more than 10,000 points; says which
/// part, and how it is written
std::vector<FigureStroke> ParseFigureStrokes(const std::string& text);

/// One stroke as a person types it: PICTURE:X,Y or PICTURE:X,Y-X,Y... All before the last ':' is
/// the picture, with no character of it written in another way.
/// @throws UsageError  not of that form
FigureStroke ParseTypedStroke(const std::string& text);

/// The text that gives these strokes. Bit for bit: ParseFigureStrokes returns the same numbers.
std::string FigureText(const std::vector<FigureStroke>& strokes);
std::string FigureText(const FigureStroke& stroke);

/// For the Problems() of options: what is wrong with the text of an option; empty if nothing is.
std::vector<std::string> FigureTextProblems(const std::string& text);

/// The picture that a stroke is in, among those of a set, which have other names than the
/// photographs in places: `capture` writes lying/IMG_2.HEIC as lying_IMG_2.jpg.
/// @return its index; -1: none of them
int IndexOfPicture(const FigureStroke& stroke, const std::vector<std::string>& captured_names);

/// A frame of a film.
struct FilmedPlace {
  std::string camera;
  int frame = 0;  ///< from 0
};
/// @return none: the stroke's picture is not CAMERA/FRAME
std::optional<FilmedPlace> FilmedPlaceOf(const FigureStroke& stroke);

/// A picture's size [px].
struct PictureSize {
  int width = 0, height = 0;
};

/// A place in the picture that `capture` wrote of a photograph: it may be smaller, and turned by 90
/// degrees clockwise where it is a portrait among landscapes (or the other way round).
/// @pre all sizes are positive
Eigen::Vector2d InCaptured(const Eigen::Vector2d& in_photograph, PictureSize photograph,
                           PictureSize captured);
/// The way back.
Eigen::Vector2d InPhotograph(const Eigen::Vector2d& in_captured, PictureSize captured,
                             PictureSize photograph);

/// The pixels (column, row) that a click or the straight lines between a stroke's points lie in,
/// each once, in the stroke's order; what lies outside of the picture is left out.
/// @param points  [px] of this picture
std::vector<Eigen::Vector2i> PixelsAlong(const std::vector<Eigen::Vector2d>& points,
                                         PictureSize picture);

}  // namespace keypose
