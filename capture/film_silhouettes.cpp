#include "capture/film_silhouettes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "capture/films/film_masks.h"
#include "capture/films/view_agreement.h"
#include "capture/pictures/working_image.h"
#include "capture/salience/salience_network.h"
#include "capture/segmentation/masking.h"
#include "capture/segmentation/trimap.h"
#include "core/io/pictures/png_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/figure_strokes.h"
#include "core/values/percent.h"
#include "core/values/size_of.h"
#include "views/shot/shot_views.h"
#include "views/shot/view_for_pictures.h"

namespace keypose::capture {
namespace {

constexpr int kSideBySide = 24;  // frames that are masked side by side

/// Puts a stroke into a frame's trimap, a few pixels wide.
void Draw(const FigureStroke& stroke, const Image8& picture, Image8& trimap) {
  constexpr int kWidth = 1;
  std::vector<Eigen::Vector2d> points = stroke.points;
  for (Eigen::Vector2d& point : points)
    point =
        point.cwiseProduct(Eigen::Vector2d(static_cast<double>(trimap.width) / picture.width,
                                           static_cast<double>(trimap.height) / picture.height));
  for (const Eigen::Vector2i& at : PixelsAlong(points, {trimap.width, trimap.height}))
    for (int y = std::max(0, at.y() - kWidth); y <= std::min(trimap.height - 1, at.y() + kWidth);
         ++y)
      for (int x = std::max(0, at.x() - kWidth); x <= std::min(trimap.width - 1, at.x() + kWidth);
           ++x)
        *trimap.at(x, y) = stroke.figure ? kObject : kBackground;
}

/// The strokes, with the frame of each.
class Strokes {
 public:
  Strokes(const std::string& text, const std::vector<ShotCamera>& cameras)
      : strokes_(ParseFigureStrokes(text)) {
    for (const FigureStroke& stroke : strokes_) {
      places_.push_back(PlaceOfStroke(stroke));
      Require(places_.back(), cameras);
    }
  }

  std::vector<ToldFrame> In(const ShotCamera& camera, FrameReader& reader, int working_px) const {
    std::vector<ToldFrame> told;
    for (std::size_t i = 0; i < strokes_.size(); ++i) {
      if (places_[i].camera != camera.name) continue;
      const Image8 picture = reader.Read(places_[i].frame, 3);
      const Image8 small = WorkingImage(picture, working_px);
      auto at = std::find_if(told.begin(), told.end(),
                             [&](const ToldFrame& t) { return t.frame == places_[i].frame; });
      if (at == told.end())
        at = told.insert(told.end(), {places_[i].frame, Image8(small.width, small.height, 1)});
      Draw(strokes_[i], picture, at->trimap);
    }
    return told;
  }

 private:
  static FilmedPlace PlaceOfStroke(const FigureStroke& stroke) {
    const auto place = FilmedPlaceOf(stroke);
    if (!place)
      throw UsageError(
          "figure: '" + stroke.picture +
          "' is not a frame of a film; write CAMERA/FRAME:X,Y, such as cam1/0:640,200");
    return *place;
  }

  static void Require(const FilmedPlace& place, const std::vector<ShotCamera>& cameras) {
    std::string names;
    for (const ShotCamera& camera : cameras) {
      names += (names.empty() ? "" : ", ") + camera.name;
      if (camera.name != place.camera) continue;
      if (place.frame >= 0 && place.frame < camera.frames()) return;
      throw UsageError("figure: frame " + std::to_string(place.frame) + " of camera " +
                       camera.name + ", whose film has the frames 0 to " +
                       std::to_string(camera.frames() - 1));
    }
    throw UsageError("figure: there is no camera '" + place.camera +
                     "' without a picture of the empty set; those are: " + names);
  }

  std::vector<FigureStroke> strokes_;
  std::vector<FilmedPlace> places_;
};

FilmSample SampleOf(FrameReader& reader, const std::vector<int>& frames, int working_px,
                    Progress* progress) {
  FilmSample sample;
  sample.frames = frames;
  for (const int frame : frames)
    sample.pictures.push_back(WorkingImage(reader.Read(frame, 3, progress), working_px));
  return sample;
}

/// One camera's film.
class CameraFilm {
 public:
  CameraFilm(const ShotCamera& camera, const FilmSilhouettesRequest& request)
      : camera_(camera), working_px_(request.mask_px) {}

  /// @param frames  of the film from which those to learn from are chosen
  void Learn(const Strokes& strokes, int frames, const AskNetwork& network, Progress* progress) {
    FrameReader reader(camera_.pictures);
    const std::vector<ToldFrame> told = strokes.In(camera_, reader, working_px_);
    FilmSample sample = SampleOf(reader, FramesToLearnFrom(frames, told), working_px_, progress);
    try {
      masker_ = std::make_unique<FilmMasker>(std::move(sample), told, network, FilmMaskOptions{});
    } catch (const InputError& error) {
      throw InputError("silhouettes: camera " + camera_.name + ": " + error.what());
    }
  }

  FilmMasker& masker() { return *masker_; }
  const ShotCamera& camera() const { return camera_; }

  /// @return frames without a mask
  int Write(const std::filesystem::path& folder, Progress* progress) {
    std::filesystem::create_directories(folder);
    FrameReader reader(camera_.pictures);
    int empty = 0;
    for (int first = 0; first < camera_.frames(); first += kSideBySide) {
      ReportProgress(progress, static_cast<double>(first) / camera_.frames(), camera_.name);
      empty += WriteSome(first, std::min(kSideBySide, camera_.frames() - first), reader, folder);
    }
    return empty;
  }

 private:
  int WriteSome(int first, int count, FrameReader& reader, const std::filesystem::path& folder) {
    std::vector<Image8> pictures, masks(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) pictures.push_back(reader.Read(first + i, 3));
    ParallelFor(count, [&](std::int64_t i) {
      masks[i] =
          masker_->Regions(first + static_cast<int>(i), WorkingImage(pictures[i], working_px_));
    });
    int empty = 0;
    for (int i = 0; i < count; ++i) masks[i] = masker_->Choose(first + i, masks[i]);
    for (const Image8& mask : masks) empty += MaskFraction(mask) == 0;
    ParallelFor(count, [&](std::int64_t i) {
      char name[32];
      std::snprintf(name, sizeof name, "%03d.png", first + static_cast<int>(i));
      WriteMaskPng(folder / name, RefinedRegions(pictures[i], masks[i]));
    });
    return empty;
  }

  const ShotCamera& camera_;
  int working_px_;
  std::unique_ptr<FilmMasker> masker_;
};

/// The cameras' views for their pictures at working size.
std::vector<View> ViewsOf(StageContext& stage, const std::filesystem::path& calibration,
                          const std::vector<ShotCamera>& cameras, int working_px) {
  const RigCalibration rig = ReadRigCalibration(calibration);
  std::vector<std::string> names;
  for (const ShotCamera& camera : cameras) names.push_back(camera.name);
  std::vector<View> views = MatchedViews(rig, names, "silhouettes");
  for (std::size_t c = 0; c < views.size(); ++c) {
    const Image8 picture = FrameReader(cameras[c].pictures).Read(0, 3);
    const AdjustedView filmed = ViewForPictures(views[c], picture, rig.up, "silhouettes");
    if (!filmed.note.empty()) stage.Note(filmed.note);
    const Image8 small = WorkingImage(picture, working_px);
    views[c] = filmed.view;
    views[c].camera = filmed.view.camera.Scaled(static_cast<double>(small.width) / picture.width);
    views[c].camera.width = small.width;
    views[c].camera.height = small.height;
  }
  return views;
}

/// Compares the cameras' learnt masks in space.
class Comparison {
 public:
  explicit Comparison(std::vector<CameraFilm>& films) : films_(films) {
    for (const int frame : films[0].masker().learnt_frames()) {
      std::vector<std::size_t> at;
      for (CameraFilm& film : films) {
        const std::vector<int>& frames = film.masker().learnt_frames();
        const auto found = std::lower_bound(frames.begin(), frames.end(), frame);
        if (found != frames.end() && *found == frame) at.push_back(found - frames.begin());
      }
      if (at.size() == films.size()) common_.push_back(at);
    }
  }

  /// Each camera learns from what the others say.
  /// @return false: the masks meet nowhere
  bool Teach(const std::vector<View>& views) {
    const std::vector<Image8> unions = Unions();
    const ViewAgreement agreement(views, unions);
    if (!agreement.meets()) return false;
    Look(agreement);
    for (std::size_t c = 0; c < films_.size(); ++c) {
      constexpr double kLimit = 2.5;
      const std::vector<float> odds = OddsOfDenials(masks_[c], denials_[c], unions[c], kLimit);
      std::vector<ImageF> heard;
      for (const Image8& mask : films_[c].masker().learnt_masks())
        heard.emplace_back(mask.width, mask.height, 1);
      for (std::size_t i = 0; i < common_.size(); ++i)
        for (std::size_t p = 0; p < denials_[c][i].data.size(); ++p)
          heard[common_[i][c]].data[p] = odds[denials_[c][i].data[p]];
      films_[c].masker().Listen(std::move(heard));
    }
    Look(agreement);
    return true;
  }

  /// Share of a camera's masks that two other cameras, or all, do not see.
  double Denied(std::size_t camera) const {
    const int many = std::min(2, static_cast<int>(films_.size()) - 1);
    double denied = 0, all = 1;
    for (std::size_t i = 0; i < common_.size(); ++i)
      for (std::size_t p = 0; p < masks_[camera][i].data.size(); ++p)
        if (masks_[camera][i].data[p] > 127) {
          denied += denials_[camera][i].data[p] >= many;
          all += 1;
        }
    return denied / all;
  }

 private:
  std::vector<Image8> Unions() const {
    std::vector<Image8> unions;
    for (CameraFilm& film : films_) {
      Image8 all = film.masker().learnt_masks().front();
      for (const Image8& mask : film.masker().learnt_masks())
        for (std::size_t p = 0; p < all.data.size(); ++p)
          all.data[p] = std::max(all.data[p], mask.data[p]);
      unions.push_back(std::move(all));
    }
    return unions;
  }

  void Look(const ViewAgreement& agreement) {
    masks_.assign(films_.size(), std::vector<Image8>(common_.size()));
    denials_ = masks_;
    ParallelFor(std::ssize(common_), [&](std::int64_t i) {
      std::vector<Image8> masks;
      for (std::size_t c = 0; c < films_.size(); ++c)
        masks.push_back(films_[c].masker().learnt_masks()[common_[i][c]]);
      std::vector<Image8> denials = agreement.LeastDenials(masks);
      for (std::size_t c = 0; c < films_.size(); ++c) {
        masks_[c][i] = std::move(masks[c]);
        denials_[c][i] = std::move(denials[c]);
      }
    });
  }

  std::vector<CameraFilm>& films_;
  std::vector<std::vector<std::size_t>> common_;  // for each frame that all learnt from, its places
  std::vector<std::vector<Image8>> masks_, denials_;  // of these frames, camera by camera
};

/// @param views  of the cameras, for their pictures at working size
void Compare(StageContext& stage, const std::vector<ShotCamera>& cameras,
             const std::vector<View>& views, std::vector<CameraFilm>& films) {
  constexpr double kContradicts = 0.05;
  ReportProgress(stage.progress(), 0.35, "comparing cameras");
  Comparison comparison(films);
  if (!comparison.Teach(views)) {
    stage.Warn(
        "the cameras' masks meet nowhere in space, so they were not compared: is the calibration "
        "of these films?");
    return;
  }
  double most = 0;
  for (std::size_t c = 0; c < films.size(); ++c) {
    const double denied = comparison.Denied(c);
    most = std::max(most, denied);
    if (denied < kContradicts) continue;
    const std::string& name = cameras[c].name;
    stage.Warn("camera " + name + ": of its masks " + PercentHalfUp(denied) +
               " lie where other cameras see nothing of the actor; look at them, and click what "
               "is not the actor (--figure '!" +
               name + "/FRAME:X,Y', in a project keypose figure --shot SHOT --not " + name +
               "/FRAME:X,Y)");
  }
  stage.Report("contradicted_share", most);
}

/// The frames from which a film's frames to learn from are chosen: films that are compared are
/// looked at in the same frames.
int FramesOf(const ShotCamera& camera, const std::vector<ShotCamera>& cameras, bool compared) {
  if (!compared) return camera.frames();
  int fewest = camera.frames();
  for (const ShotCamera& other : cameras) fewest = std::min(fewest, other.frames());
  return 20 * fewest >= 19 * camera.frames() ? fewest : camera.frames();
}

/// The network, or nothing; says that it is missing.
AskNetwork NetworkFor(StageContext& stage, const FilmSilhouettesRequest& request,
                      std::unique_ptr<SalienceNetwork>& network) {
  if (!request.network) return {};
  const auto file = FindSalienceNetwork();
  if (!file) {
    stage.Note(std::string("masks without the network's second opinion: ") + kNoSalience);
    return {};
  }
  network = SalienceNetwork::Open(*file);
  return [&network](const Image8& rgb) { return network->Of(rgb); };
}

}  // namespace

FilmSilhouettesCount WriteFilmSilhouettes(StageContext& stage,
                                          const std::vector<ShotCamera>& cameras,
                                          const std::filesystem::path& calibration,
                                          const FilmSilhouettesRequest& request,
                                          const std::filesystem::path& out) {
  constexpr std::size_t kFewestCompared = 3;
  const Strokes strokes(request.figure, cameras);
  const bool compared = !calibration.empty() && cameras.size() >= kFewestCompared;
  // Before the minutes of learning: a calibration of other films is refused.
  const std::vector<View> views =
      compared ? ViewsOf(stage, calibration, cameras, request.mask_px) : std::vector<View>();
  std::vector<CameraFilm> films;
  for (const ShotCamera& camera : cameras) films.emplace_back(camera, request);
  {
    std::unique_ptr<SalienceNetwork> network;
    const AskNetwork ask = NetworkFor(stage, request, network);
    for (std::size_t i = 0; i < films.size(); ++i) {
      ReportProgress(stage.progress(), 0.35 * static_cast<double>(i) / SizeOf(films),
                     "learning " + cameras[i].name);
      films[i].Learn(strokes, FramesOf(cameras[i], cameras, !calibration.empty()), ask,
                     stage.progress());
    }
  }
  if (compared) Compare(stage, cameras, views, films);
  for (CameraFilm& film : films) film.masker().EndLearning();
  FilmSilhouettesCount count;
  for (std::size_t i = 0; i < films.size(); ++i) {
    const double from = 0.4 + 0.6 * static_cast<double>(i) / SizeOf(films);
    SubProgress progress(stage.progress(), from, from + 0.6 / SizeOf(films));
    count.empty += films[i].Write(out / cameras[i].name, &progress);
    count.masks += cameras[i].frames();
    for (const std::string& warning : films[i].masker().Warnings(cameras[i].name))
      stage.Warn(warning);
  }
  return count;
}

}  // namespace keypose::capture
