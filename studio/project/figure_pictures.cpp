#include "studio/project/figure_pictures.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/values/errors.h"
#include "studio/project/films.h"
#include "studio/project/originals.h"
#include "studio/project/pose_photographs.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A tenth of a pixel: more nobody can mean.
Eigen::Vector2d Tenths(const Eigen::Vector2d& at) {
  return {std::round(10 * at.x()) / 10, std::round(10 * at.y()) / 10};
}

/// The points of the page's stroke. @throws UsageError  none, or one that is not within
std::vector<Eigen::Vector2d> SharesOf(const json& one) {
  std::vector<Eigen::Vector2d> shares;
  for (const json& point : one.at("points")) {
    const double x = point.at(0), y = point.at(1);
    if (!(x >= 0 && x <= 1 && y >= 0 && y <= 1))
      throw UsageError(fmt::format("the place {}, {} lies outside of {}", x, y,
                                   one.at("picture").get<std::string>()));
    shares.emplace_back(x, y);
  }
  if (shares.empty()) throw UsageError("a stroke has no points");
  return shares;
}

/// The photographs of a pose under the page's names, and the sizes of their pictures.
class ShownPhotographs : public FigurePictures {
 public:
  ShownPhotographs(Snapshot& snapshot, const std::string& pose)
      : snapshot_(snapshot), pose_(pose), originals_(snapshot, pose) {
    for (const json& one : PhotographsJson(snapshot, pose)) names_.push_back(one.at("name"));
  }

  json JsonOf(const FigureStroke& stroke) const override {
    json one = {{"text", FigureText(stroke)},
                {"picture", stroke.picture},
                {"figure", stroke.figure},
                {"points", json::array()},
                {"gone", true}};
    const int i = IndexOfPicture(stroke, names_);
    const std::string name = i < 0 ? "" : names_[static_cast<std::size_t>(i)];
    if (i < 0 || originals_.FileOf(name).empty()) return one;
    const auto [photograph, shown] = SizesOf(name);
    one["picture"] = name;
    one["gone"] = false;
    for (const Eigen::Vector2d& point : stroke.points) {
      const Eigen::Vector2d at = InCaptured(point, photograph, shown);
      one["points"].push_back({at.x() / shown.width, at.y() / shown.height});
    }
    return one;
  }

  /// @throws UsageError  no such photograph, or a place outside of it
  FigureStroke StrokeOf(const json& one) const override {
    const std::string name = one.at("picture");
    const fs::path file = originals_.FileOf(name);
    if (file.empty())
      throw UsageError(fmt::format("pose '{}' has no photograph '{}'", pose_, name));
    FigureStroke stroke;
    stroke.picture = file.lexically_relative(snapshot_.PhotoFolder(pose_)).generic_string();
    stroke.figure = one.at("figure");
    const auto [photograph, shown] = SizesOf(name);
    for (const Eigen::Vector2d& share : SharesOf(one))
      stroke.points.push_back(Tenths(
          InPhotograph({share.x() * shown.width, share.y() * shown.height}, shown, photograph)));
    return stroke;
  }

 private:
  struct Sizes {
    PictureSize photograph, shown;
  };
  Sizes SizesOf(const std::string& name) const {
    const ImageInfo info = OriginalInfo(originals_.FileOf(name));
    const PictureSize photograph{info.width, info.height};
    const auto [width, height] = PhotographSize(snapshot_, pose_, name);
    return {photograph, width > 0 ? PictureSize{width, height} : photograph};
  }

  Snapshot& snapshot_;
  std::string pose_;
  Originals originals_;
  std::vector<std::string> names_;
};

/// The frames of a shot's films, which the page calls CAMERA/FRAME as the strokes do.
class ShownFrames : public FigurePictures {
 public:
  ShownFrames(const Snapshot& snapshot, const std::string& shot)
      : shot_(shot), folder_(FilmFolder(snapshot.project(), snapshot.file(), shot)) {}

  json JsonOf(const FigureStroke& stroke) const override {
    json one = {{"text", FigureText(stroke)},
                {"picture", stroke.picture},
                {"figure", stroke.figure},
                {"points", json::array()},
                {"gone", true}};
    try {
      const PictureSize size = SizeOf(stroke);
      for (const Eigen::Vector2d& point : stroke.points)
        one["points"].push_back({point.x() / size.width, point.y() / size.height});
      one["gone"] = false;
    } catch (const Error&) {
      // Its film is not there any more, or shorter: the list on the page says so.
    }
    return one;
  }

  FigureStroke StrokeOf(const json& one) const override {
    FigureStroke stroke;
    stroke.picture = one.at("picture");
    stroke.figure = one.at("figure");
    const PictureSize size = SizeOf(stroke);
    for (const Eigen::Vector2d& share : SharesOf(one))
      stroke.points.push_back(Tenths({share.x() * size.width, share.y() * size.height}));
    return stroke;
  }

 private:
  PictureSize SizeOf(const FigureStroke& stroke) const {
    const auto place = FilmedPlaceOf(stroke);
    if (place)
      for (const ShotCamera& camera : FilmsIn(folder_))
        if (camera.name == place->camera && place->frame < camera.pictures.frames)
          return FrameSize(camera.pictures, place->frame);
    throw UsageError(fmt::format("shot '{}' has no frame '{}'", shot_, stroke.picture));
  }

  std::string shot_;
  fs::path folder_;
};

}  // namespace

std::unique_ptr<FigurePictures> PicturesOfFigure(Snapshot& snapshot, const std::string& pose) {
  if (snapshot.graph().kind == pipeline::ProjectKind::kPerformance)
    return std::make_unique<ShownFrames>(snapshot, pose);
  return std::make_unique<ShownPhotographs>(snapshot, pose);
}

}  // namespace keypose::studio
