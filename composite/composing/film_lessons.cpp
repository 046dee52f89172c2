#include "composite/composing/film_lessons.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "composite/follow/follow_film.h"
#include "composite/layer/linear_light.h"
#include "composite/light/plate_exposure.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

using Eigen::Vector3d;

constexpr int kMostFrames = 24, kFewFrames = 6;  // of the film that are looked at
constexpr double kMostBytes = 6.0 * (1 << 30);  // that they may take: of 24 megapixels seven frames
constexpr double kBytesAPixel = 36;             // that a frame takes while it is looked at
constexpr int kMostShadowFrames = 3, kShadowSamples = 900;
constexpr double kLeastExplained = 0.1;  // of the lost light; less is no shadow
constexpr double kLeastLight = 0.2;      // of nine pixels' channels: enough to compare
constexpr double kMargin = 0.012;  // of the picture's width: how far from the character it counts
constexpr double kCompareBlur = 0.0025;  // of the picture's width

/// One of the frames that are looked at.
struct Looked {
  const FilmedPicture* picture = nullptr;
  View view;
  ImageF moving_plate;  // the plate of a moving camera
  Image8 stored;
  ImageF light;  // divided by its exposure
  PointsX3 points;
  std::unique_ptr<RayScene> scene;
  ImageF layer;  // with gains of 1
  Image8 away;
  ImageF kept;
};

/// How many frames are looked at: the same on every machine, so that results are.
int FramesToLookAt(const Camera& camera) {
  const double pixels = static_cast<double>(camera.width) * camera.height;
  return static_cast<int>(
      std::clamp<double>(kMostBytes / (kBytesAPixel * pixels), kFewFrames, kMostFrames));
}

/// All anchors first, then others spread evenly, at most so many; in the film's order.
std::vector<const FilmedPicture*> ChooseFrames(const Film& film, int most_frames) {
  std::vector<const FilmedPicture*> anchors, others;
  for (const FilmedPicture& picture : film.pictures)
    if (picture.shows || !film.plate_at)  // of a passing camera only what the animation reaches
      (picture.anchor >= 0 ? anchors : others).push_back(&picture);
  std::vector<const FilmedPicture*> chosen;
  const auto spread = [&](const std::vector<const FilmedPicture*>& from, int most) {
    const int count = std::min(most, SizeOf(from));
    for (int i = 0; i < count; ++i)
      chosen.push_back(from[static_cast<std::size_t>(i) * from.size() / count]);
  };
  spread(anchors, most_frames / 2);
  spread(others, most_frames - SizeOf(chosen));
  std::sort(chosen.begin(), chosen.end(),
            [](const auto* a, const auto* b) { return a->film < b->film; });
  return chosen;
}

/// 255 within `radius` pixels (of a square) of what the layer covers, except behind props.
Image8 AwayMask(const ImageF& layer, const Image8& holdout, int radius) {
  Image8 rows(layer.width, layer.height, 1), away(layer.width, layer.height, 1);
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x)
      if (layer.at(x, y)[3] > 0)
        for (int k = std::max(0, x - radius); k <= std::min(layer.width - 1, x + radius); ++k)
          *rows.at(k, y) = 255;
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x) {
      for (int k = std::max(0, y - radius); k <= std::min(layer.height - 1, y + radius); ++k)
        if (*rows.at(x, k)) *away.at(x, y) = 255;
      if (!holdout.empty() && *holdout.at(x, y) > 127) *away.at(x, y) = 0;
    }
  return away;
}

class Lesson {
 public:
  Lesson(const ShotGeometry& geometry, const Looks& looks, const Film& film,
         const LearnOptions& options, Progress* progress)
      : geometry_(geometry),
        looks_(looks),
        film_(film),
        camera_(geometry.ViewAt(0).camera),
        table_(geometry.Table()),
        rays_(camera_),
        options_(options),
        progress_(progress) {}

  FilmLessons Learn() {
    LookAtFrames();
    lessons_.exposures.assign(film_.pictures.size(), Vector3d::Ones());
    LearnPlate();
    if (film_.alpha && !moves()) LearnPlateAlpha();
    LearnShadow();
    LearnLight();
    LearnGrain();
    LearnBlur();
    for (const FilmedPicture& picture : film_.pictures) Exposure(picture);
    if (options_.follow) Follow();
    return std::move(lessons_);
  }

 private:
  bool moves() const { return static_cast<bool>(film_.plate_at); }
  bool has_plate() const { return moves() || !given_.empty(); }
  /// The set in the exposure of the plate.
  const ImageF& SetOf(const Looked& look) const {
    return moves() ? look.moving_plate : lessons_.plate.light;
  }

  void LookAtFrames() {
    const std::vector<const FilmedPicture*> chosen = ChooseFrames(film_, FramesToLookAt(camera_));
    const int margin = std::max(3, static_cast<int>(kMargin * camera_.width));
    bool seen = false;
    for (const FilmedPicture* picture : chosen) {
      if (progress_ && progress_->cancelled()) throw Cancelled();
      ReportProgress(progress_, 0.5 * SizeOf(looked_) / SizeOf(chosen), "looking at the film");
      Looked look;
      look.picture = picture;
      ImageF read = film_.read(picture->film);
      look.stored = Rounded(LevelsIn(film_, read));
      look.light = LightIn(film_, std::move(read));
      look.view = geometry_.ViewAt(picture->animation);
      if (moves()) look.moving_plate = LightIn(film_, film_.plate_at(picture->animation).picture);
      look.points = geometry_.Points(picture->animation);
      look.scene = std::make_unique<RayScene>(look.points, looks_.faces);
      look.layer = RenderLayer(
          looks_.At(picture->animation), look.points, *look.scene, {}, look.view, rays_,
          picture->anchor >= 0 ? std::min(options_.along, 3) : 1, &table_, film_.props());
      look.away = AwayMask(look.layer, film_.holdout, picture->anchor >= 0 ? margin : 2 * margin);
      seen = seen ||
             std::find(look.away.data.begin(), look.away.data.end(), 255) != look.away.data.end();
      looked_.push_back(std::move(look));
    }
    if (!seen && !looked_.empty())
      throw InputError(
          "composite: the character is in none of the filmed frames: by the shot it is outside of "
          "the picture, or a holdout hides all of it; locate it again, or look at the holdout");
  }

  std::vector<PlateFrame> PlateFrames() const {
    std::vector<PlateFrame> frames;
    for (const Looked& look : looked_) frames.push_back({look.light, look.away, look.kept});
    return frames;
  }

  CleanPlate CleanPlateNow() const {
    return MakeCleanPlate(PlateFrames(), given_, film_.shown ? kUnbounded : kBounded);
  }

  /// Levels of 8 bits of light.
  Image8 LevelsOfLight(const ImageF& light) const {
    return film_.shown ? Rounded(film_.shown(light)) : SrgbOf(light);
  }

  void LearnPlate() {
    ReportProgress(progress_, 0.5, "clean plate");
    if (moves()) {
      for (Looked& look : looked_) Normalise(&look);
      return;
    }
    given_ = LightIn(film_, film_.given_plate);
    lessons_.plate = CleanPlateNow();
    if (looked_.empty()) return;
    for (Looked& look : looked_) Normalise(&look);
    if (!given_.empty()) {
      const Vector3d exposure = ExposureOf(lessons_.plate.light, given_, {});
      given_ = Scaled(std::move(given_), exposure);
    }
    lessons_.plate = CleanPlateNow();
  }

  /// What the key left of the set: the mean of the frames that show it; what none shows, as most of
  /// the set.
  void LearnPlateAlpha() {
    ImageF sum(camera_.width, camera_.height, 1), count = sum;
    for (const Looked& look : looked_) {
      const ImageF alpha = film_.alpha(look.picture->film);
      for (std::size_t i = 0; i < sum.data.size(); ++i)
        if (look.away.data[i] <= 127) {
          sum.data[i] += alpha.data[i];
          count.data[i] += 1;
        }
    }
    double all = 0, seen = 0;
    for (std::size_t i = 0; i < sum.data.size(); ++i) {
      all += sum.data[i];
      seen += count.data[i];
    }
    const float most = 2 * all > seen ? 1.0f : 0.0f;
    for (std::size_t i = 0; i < sum.data.size(); ++i)
      sum.data[i] = count.data[i] > 0 ? sum.data[i] / count.data[i] : most;
    lessons_.plate_alpha = std::move(sum);
  }

  static ImageF Scaled(ImageF image, const Vector3d& factors) {
    for (std::size_t i = 0; i < image.data.size(); ++i)
      image.data[i] *= static_cast<float>(factors[static_cast<Eigen::Index>(i % 3)]);
    return image;
  }

  void Normalise(Looked* look) {
    const Vector3d exposure = ExposureOf(look->light, SetOf(*look), look->away);
    look->light = Scaled(std::move(look->light), exposure.cwiseInverse());
  }

  /// Places of the table around the character, and what they lost of the light that `other` has
  /// there: a frame of the same view, or null for the given plate.
  ShadowSamples SamplesOf(const Looked& look, const Looked* other) const {
    ShadowSamples samples{look.scene.get(), {}, {}, other ? other->scene.get() : nullptr};
    const Rigid3 world_from_camera = look.view.camera_from_world.Inverse();
    const Vector3d& eye = world_from_camera.translation;
    const double height = (eye - table_.origin).dot(table_.up);
    std::vector<std::pair<Vector3d, double>> all;
    const ImageF& plate = moves() ? look.moving_plate : given_;
    const ImageF& brighter = other ? other->light : plate;
    for (int y = 2; y < look.light.height - 2; y += 3)
      for (int x = 2; x < look.light.width - 2; x += 3) {
        if (*look.away.at(x, y) > 127 || (other && *other->away.at(x, y) > 127)) continue;
        const Vector3d ray = world_from_camera.rotation * rays_.At(x, y, 0.5, 0.5);
        const double down = -ray.dot(table_.up);
        if (!(down * height > 0)) continue;
        const Vector3d place = world_from_camera.translation + height / down * ray;
        if ((place - table_.origin).norm() > 1.6 * table_.diagonal) continue;
        if (film_.set && film_.set->scene.Occluded(eye, ray, 0, 0.999 * height / down)) continue;
        const double light = LightAround(look.light, x, y), full = LightAround(brighter, x, y);
        if (full > kLeastLight && light > 0) all.emplace_back(place, 1 - light / full);
      }
    const std::size_t step = std::max<std::size_t>(1, all.size() / kShadowSamples);
    for (std::size_t i = step / 2; i < all.size(); i += step) {
      samples.places.push_back(all[i].first);
      samples.lost.push_back(all[i].second);
    }
    return samples;
  }

  static double LightAround(const ImageF& light, int x, int y) {
    double sum = 0;
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i)
        for (int c = 0; c < 3; ++c) sum += light.at(x + i, y + j)[c];
    return sum;
  }

  /// Located frames against the given plate; without one, two by two, the farthest apart first. A
  /// plate that was made from the film has some of the shadow in it.
  std::vector<ShadowSamples> AllSamples() const {
    std::vector<const Looked*> located;
    for (const Looked& look : looked_)
      if (look.picture->anchor >= 0) located.push_back(&look);
    if (!has_plate() && SizeOf(located) < 2)
      for (const Looked& look : looked_)
        if (look.picture->anchor < 0) located.push_back(&look);
    std::vector<ShadowSamples> samples;
    // Spread over the shot: the first ones alone say little of a lamp when the character has hardly
    // moved, and an error that fits their shadow shows at the far end of later ones.
    const int count = SizeOf(located),
              chosen = has_plate() ? std::min(count, kMostShadowFrames) : 0;
    for (int i = 0; i < chosen; ++i)
      samples.push_back(
          SamplesOf(*located[chosen > 1 ? i * (count - 1) / (chosen - 1) : 0], nullptr));
    for (int apart = SizeOf(located) - 1; !has_plate() && apart > 0; --apart)
      for (int i = 0; i + apart < SizeOf(located) && SizeOf(samples) < kMostShadowFrames; ++i)
        samples.push_back(SamplesOf(*located[i], located[i + apart]));
    return samples;
  }

  void LearnShadow() {
    ReportProgress(progress_, 0.6, "shadow");
    const std::vector<ShadowSamples> samples = AllSamples();
    if (looked_.empty()) {
      lessons_.shadow.strength = ShadowOf(options_.stated, geometry_.ViewAt(0), table_.up);
      return;
    }
    lessons_.shadow = FitShadow(samples, table_);
    if (lessons_.shadow.explained < kLeastExplained) return ForgetShadow(!samples.empty());
    for (Looked& look : looked_) look.kept = KeptOf(look, table_);
    if (!moves()) lessons_.plate = CleanPlateNow();
  }

  void ForgetShadow(bool looked_for) {
    lessons_.shadow.strength.sky = lessons_.shadow.strength.lamp = 0;
    for (Looked& look : looked_) look.kept = {};
    if (!moves()) lessons_.plate = CleanPlateNow();
    if (looked_for)
      lessons_.notes.push_back(
          "no shadow on the table was found in the filmed frames, so in-betweens have none");
  }

  ImageF KeptOf(const Looked& look, const Ground& table) const {
    return ShadowPicture(*look.scene, table, lessons_.shadow.strength, film_.set.get(), look.view,
                         rays_);
  }

  void LearnLight() {
    ReportProgress(progress_, 0.8, "light");
    std::vector<ObservedGains> observed;
    for (const Looked& look : looked_) {
      // A moving camera is located between keys too, where the animation passes beside the film.
      if (look.picture->anchor < 0 || (moves() && !look.picture->keyed)) continue;
      lessons_.light_frames.push_back(look.picture->animation);
      observed.push_back(ObserveGains(look.light, look.layer, film_.holdout, look.points,
                                      looks_.faces, *look.scene, look.view,
                                      kCompareBlur * camera_.width));
    }
    if (observed.empty()) return StateLight();
    lessons_.light = FitShotLight(observed, looks_.faces);
    if (options_.stated != StatedLight())
      lessons_.notes.push_back(
          "the light was learnt from the filmed frames; what is stated of lamp and brightness is "
          "not used");
  }

  void StateLight() {
    const StatedLight& stated = options_.stated;
    lessons_.light = LightOf(stated, looks_.plain, geometry_.ViewAt(0), table_.up);
    lessons_.notes.push_back(
        stated.lamp > 0
            ? fmt::format("no located frame was filmed; by what is stated {:.0f} % of the light "
                          "comes from a lamp at {:.0f} degrees, {:.0f} high",
                          100 * stated.lamp, stated.from_deg, stated.height_deg)
            : "no located frame was filmed, so the character has the light of an even sky; where "
              "the set has a lamp, say how strong it is and where it stands (lamp, lamp_from, "
              "lamp_height)");
  }

  void LearnGrain() {
    ReportProgress(progress_, 0.85, "grain");
    for (std::size_t i = 0; moves() && i < looked_.size() && !lessons_.grain; ++i)
      lessons_.grain =
          MeasureGrain(looked_[i].stored, LevelsOfLight(looked_[i].moving_plate), looked_[i].away);
    for (std::size_t i = 0; !moves() && i + 1 < looked_.size() && !lessons_.grain; ++i) {
      Image8 away = looked_[i].away;
      for (std::size_t k = 0; k < away.data.size(); ++k)
        away.data[k] = std::max(away.data[k], looked_[i + 1].away.data[k]);
      lessons_.grain = MeasureGrain(looked_[i].stored, looked_[i + 1].stored, away);
    }
    if (!moves() && !lessons_.grain && looked_.size() == 1)
      lessons_.grain = MeasureGrain(looked_[0].stored, LevelsOfLight(lessons_.plate.light),
                                    looked_[0].away, film_.given_plate.empty() ? 0 : 1);
    if (!lessons_.grain && !looked_.empty())
      lessons_.notes.push_back("the grain could not be measured, so in-betweens have none");
  }

  /// The blur of the lens that makes the character's render most like a filmed frame.
  void LearnBlur() {
    ReportProgress(progress_, 0.9, "sharpness");
    const auto look = std::find_if(looked_.begin(), looked_.end(),
                                   [](const Looked& l) { return l.picture->anchor >= 0; });
    if (look == looked_.end()) return;
    const int frame = look->picture->animation;
    const PointsX3 gains =
        GainsAt(geometry_, lessons_, frame, VertexNormals(look->points, looks_.faces));
    const ImageF layer = RenderLayer(looks_.At(frame), look->points, *look->scene, gains,
                                     look->view, rays_, options_.along, &table_, film_.props());
    double least = std::numeric_limits<double>::infinity();
    for (const double sigma : {0.0, 0.3, 0.45, 0.6, 0.8, 1.0, 1.3, 1.7}) {
      const double error = ErrorOf(*look, Blurred(layer, sigma));
      if (error < least) {
        least = error;
        lessons_.blur_px = sigma;
      }
    }
  }

  double ErrorOf(const Looked& look, const ImageF& layer) const {
    double sum = 0;
    for (int y = 0; y < layer.height; ++y)
      for (int x = 0; x < layer.width; ++x) {
        const float* over = layer.at(x, y);
        if (over[3] <= 0.01f) continue;
        for (int c = 0; c < 3; ++c) {
          const float plate =
              SetOf(look).at(x, y)[c] * (look.kept.empty() ? 1.0f : *look.kept.at(x, y));
          const double d = over[c] + (1 - over[3]) * plate - look.light.at(x, y)[c];
          sum += std::min(d * d, 0.01);
        }
      }
    return sum;
  }

  void Exposure(const FilmedPicture& picture) {
    if (moves() && !picture.shows) return;  // no picture is made beside it
    const auto look = std::find_if(looked_.begin(), looked_.end(),
                                   [&](const Looked& l) { return l.picture == &picture; });
    const Image8 away = look == looked_.end() ? Image8() : look->away;
    lessons_.exposures[&picture - film_.pictures.data()] =
        ExposureOf(LightIn(film_, film_.read(picture.film)), SetAt(picture), away);
  }

  /// Bends all frames of the animation that were filmed until they lie on the film, and observes
  /// their light anew.
  void Follow() {
    std::map<int, PointsX3> shifts;
    std::vector<ObservedGains> observed;
    std::vector<int> frames;
    for (const FilmedPicture& picture : film_.pictures) {
      if (!picture.shows || shifts.count(picture.animation)) continue;
      ReportProgress(progress_, 0.5, "following the film");
      FollowOne(picture, &shifts, &observed);
      frames.push_back(picture.animation);
    }
    if (frames.empty()) return;
    lessons_.beside_px /= SizeOf(frames);
    lessons_.light = FitShotLight(observed, looks_.faces);
    lessons_.light_frames = frames;
    lessons_.shifts = std::move(shifts);
  }

  void FollowOne(const FilmedPicture& picture, std::map<int, PointsX3>* shifts,
                 std::vector<ObservedGains>* observed) {
    const std::size_t index = &picture - film_.pictures.data();
    const ImageF light =
        Scaled(LightIn(film_, film_.read(picture.film)), lessons_.exposures[index].cwiseInverse());
    PointsX3 points = geometry_.Points(picture.animation);
    const Character character = looks_.At(picture.animation);
    const PointsX3 gains =
        GainsAt(geometry_, lessons_, picture.animation, VertexNormals(points, looks_.faces));
    const View view = geometry_.ViewAt(picture.animation);
    const ImageF behind = Behind(points, SetAt(picture), view);
    const Followed followed = FollowFilm({light, behind, film_.holdout, character, gains, view,
                                          rays_, &table_, lessons_.blur_px, film_.props()},
                                         points);
    points += followed.shifts;
    lessons_.beside_px += followed.mean_px;
    const RayScene scene(points, looks_.faces);
    const ImageF layer = RenderLayer(character, points, scene, {}, view, rays_,
                                     std::min(options_.along, 3), &table_, film_.props());
    observed->push_back(ObserveGains(light, layer, film_.holdout, points, looks_.faces, scene, view,
                                     kCompareBlur * camera_.width));
    shifts->emplace(picture.animation, followed.shifts);
  }

  ImageF SetAt(const FilmedPicture& picture) const {
    return moves() ? LightIn(film_, film_.plate_at(picture.animation).picture)
                   : lessons_.plate.light;
  }

  /// The plate with the figure's shadow.
  ImageF Behind(const PointsX3& points, ImageF behind, const View& view) const {
    const ShadowStrength& strength = lessons_.shadow.strength;
    if (!(strength.sky > 0 || strength.lamp > 0)) return behind;
    const ImageF kept = ShadowPicture(RayScene(points, looks_.faces), table_, strength,
                                      film_.set.get(), view, rays_);
    for (std::size_t i = 0; i < behind.data.size(); ++i) behind.data[i] *= kept.data[i / 3];
    return behind;
  }

  const ShotGeometry& geometry_;
  const Looks& looks_;
  const Film& film_;
  Camera camera_;
  Ground table_;
  PixelRays rays_;
  LearnOptions options_;
  Progress* progress_;
  ImageF given_;  // the given plate, in the exposure of the one that is made
  std::vector<Looked> looked_;
  FilmLessons lessons_;
};

}  // namespace

FilmLessons LearnFromFilm(const ShotGeometry& geometry, const Looks& looks, const Film& film,
                          const LearnOptions& options, Progress* progress) {
  return Lesson(geometry, looks, film, options, progress).Learn();
}

}  // namespace keypose::composite
