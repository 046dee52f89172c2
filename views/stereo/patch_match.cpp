#include "views/stereo/patch_match.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <mutex>
#include <numeric>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"

namespace keypose::stereo {
namespace {

std::uint64_t Mixed(std::uint64_t z) {
  z += 0x9E3779B97F4A7C15ull;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return z ^ (z >> 31);
}
float Unit(std::uint64_t hash) { return static_cast<float>(hash >> 40) * (1.0f / (1 << 24)); }

// The sample images of the most recently requested views. Views that are neighbours in file order
// share most of their sources; the images of all views together would be a sixth of the memory.
class SampleCache {
 public:
  SampleCache(const std::vector<PreparedView>& views, int level)
      : views_(views), level_(level), entries_(views.size()) {}

  std::shared_ptr<const SampleImage> Get(int view) {
    const std::scoped_lock lock(mutex_);
    Entry& entry = entries_[view];
    entry.asked = ++clock_;
    if (entry.image) return entry.image;
    entry.image =
        std::make_shared<const SampleImage>(MakeSampleImage(views_[view].levels[level_].grey));
    std::shared_ptr<const SampleImage> image = entry.image;
    if (++kept_ > kKept) Forget();
    return image;
  }

 private:
  static constexpr int kKept = 24;
  struct Entry {
    std::shared_ptr<const SampleImage> image;
    std::int64_t asked = 0;
  };
  void Forget() {
    Entry* oldest = nullptr;
    for (Entry& entry : entries_)
      if (entry.image && (!oldest || entry.asked < oldest->asked)) oldest = &entry;
    oldest->image.reset();
    --kept_;
  }

  const std::vector<PreparedView>& views_;
  const int level_;
  std::mutex mutex_;
  std::vector<Entry> entries_;
  std::int64_t clock_ = 0;
  int kept_ = 0;
};

class Estimator {
 public:
  Estimator(const std::vector<PreparedView>& views, const std::vector<std::vector<int>>& sources,
            const std::vector<DepthBounds>& bounds,
            const std::vector<std::vector<Eigen::Vector3d>>& seeds,
            const PatchMatchOptions& options, Progress* progress)
      : views_(views),
        sources_(sources),
        bounds_(bounds),
        seeds_(seeds),
        options_(options),
        progress_(progress),
        maps_(views.size()),
        inverse_depths_(views.size()),
        priors_(views.size()),
        evaluations_(views.size(), 0) {
    levels_ = views.empty() ? 0 : SizeOf(views[0].levels);
    // The work of a pass grows fourfold with each finer level.
    for (int level = 0; level < levels_; ++level)
      total_work_ += Passes(level) * std::pow(0.25, level);
  }

  PatchMatchResult Run() {
    for (int level = levels_ - 1; level >= 0; --level) {
      ForViews([&](int i) {
        level == levels_ - 1 ? Start(i, level) : Descend(i, level);
        maps_[i].Pack();
      });
      samples_ = std::make_unique<SampleCache>(views_, level);
      RunLevel(level);
    }
    PatchMatchResult result;
    result.maps = std::move(maps_);
    for (PlaneMap& map : result.maps) map.DropMatches();
    result.evaluations = std::accumulate(evaluations_.begin(), evaluations_.end(), std::int64_t{0});
    return result;
  }

 private:
  int PhotometricPasses(int level) const {
    return level == levels_ - 1 ? options_.coarse_passes
                                : options_.fine_passes + (level > 0 ? 1 : 0);
  }
  int GeometricPasses(int level) const {
    return level == 0 ? options_.geometric_passes : std::min(1, options_.geometric_passes);
  }
  int Passes(int level) const { return PhotometricPasses(level) + GeometricPasses(level); }

  template <class Body>
  void ForViews(const Body& body) {
    ParallelFor(std::ssize(views_), [&](std::int64_t i) {
      if (!sources_[i].empty()) body(static_cast<int>(i));
    });
  }

  SweepInputs Inputs(int i, int level) const {
    SweepInputs inputs;
    inputs.reference = &views_[i];
    for (const int s : sources_[i]) inputs.sources.push_back(&views_[s]);
    inputs.level = level;
    inputs.bounds = &bounds_[i];
    // Halving averages four pixels, which halves independent noise.
    const double noise = std::max(options_.noise, std::min(views_[i].noise, 4 * options_.noise)) *
                         std::pow(0.5, level);
    inputs.noise_variance = static_cast<float>(noise * noise);
    if (level == 0 && levels_ > 1)
      inputs.narrow_variance =
          static_cast<float>(options_.narrow_texture * options_.narrow_texture * noise * noise);
    inputs.seed = Mixed(options_.seed * 1000003 + i);
    inputs.prior = priors_[i].empty() ? nullptr : &priors_[i];
    return inputs;
  }

  static int Refinements(bool coarsest, bool parabola, bool exact) {
    if (coarsest) return 4;
    if (parabola) return 1;
    return exact ? 2 : 3;
  }

  void RunLevel(int level) {
    const bool coarsest = level == levels_ - 1;
    float depth_step = coarsest ? 3.0f : 0.6f, slope_step = coarsest ? 0.6f : 0.25f;
    for (int pass = 0; pass < Passes(level); ++pass) {
      const bool geometric = pass >= PhotometricPasses(level),
                 first_geometric = pass == PhotometricPasses(level);
      SweepSettings settings;
      // All sources are compared for all planes in the first pass of a level, and at the end of the
      // coarsest level, when the planes are accurate enough for a choice.
      const bool settled = coarsest && pass + 1 == PhotometricPasses(level);
      settings.select_sources = !geometric && ((level > 0 && pass == 0) || settled || levels_ == 1);
      settings.refresh = pass == 0;
      settings.far_areas = coarsest;
      settings.parabola = level == 0 && pass == Passes(level) - 1;
      settings.refinements = Refinements(coarsest, settings.parabola, geometric || level == 0);
      settings.depth_step_px = depth_step;
      settings.slope_step = slope_step;
      settings.pass = pass;
      if (geometric) Freeze(level);
      ForViews([&](int i) {
        SweepInputs inputs = Inputs(i, level);
        std::vector<std::shared_ptr<const SampleImage>> samples;
        for (const int s : sources_[i]) {
          samples.push_back(samples_->Get(s));
          inputs.samples.push_back(samples.back().get());
        }
        if (geometric)
          for (const int s : sources_[i])
            inputs.source_inverse_depths.push_back(&inverse_depths_[s]);
        maps_[i].Unpack();
        evaluations_[i] += Sweep(inputs, settings, &maps_[i]);
        maps_[i].Pack();
      });
      depth_step *= first_geometric ? 1.0f : 0.5f;
      slope_step *= 0.6f;
      work_ += std::pow(0.25, level);
      ReportProgress(progress_, work_ / total_work_,
                     geometric ? "geometric consistency" : "matching");
    }
  }

  // Copies the depths of all views, which the other views read while the maps change.
  void Freeze(int level) {
    ParallelFor(std::ssize(views_), [&](std::int64_t i) {
      const Pinhole& camera = views_[i].camera(level);
      if (inverse_depths_[i].width != camera.width || inverse_depths_[i].height != camera.height)
        inverse_depths_[i] = NoDepths(static_cast<int>(i), level);
      maps_[i].ForEachPlane([&](std::size_t pixel, std::size_t place) {
        inverse_depths_[i].Set(pixel, maps_[i].InverseDepth(place));
      });
    });
  }

  DepthImage NoDepths(int i, int level) const {
    const Pinhole& camera = views_[i].camera(level);
    const DepthBounds& bounds = bounds_[i];
    float lowest = std::numeric_limits<float>::max(), highest = 0;
    for (std::size_t k = 0; k < bounds.nearest.data.size(); ++k)
      if (bounds.nearest.data[k] > 0) {
        lowest = std::min(lowest, bounds.farthest.data[k]);
        highest = std::max(highest, bounds.nearest.data[k]);
      }
    return DepthImage(camera.width, camera.height, std::min(lowest, highest), highest);
  }

  // Half of the pixels start at the hull's front, half at a random depth within the hull. Known
  // points replace both.
  void Start(int i, int level) {
    const SweepInputs inputs = Inputs(i, level);
    const Pinhole& camera = views_[i].camera(level);
    const DepthBounds& bounds = bounds_[i];
    maps_[i] = PlaneMap(camera, SizeOf(sources_[i]));
    const std::uint16_t all = static_cast<std::uint16_t>(
        (1u << std::min<std::size_t>(kSourcesUsed, sources_[i].size())) - 1);
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        if (!Visited(inputs, x, y)) continue;
        const std::size_t index = static_cast<std::size_t>(y) * camera.width + x;
        const std::uint64_t hash = Mixed(inputs.seed ^ (index * 2 + 1));
        const float nearest = *bounds.nearest.at(x, y), farthest = *bounds.farthest.at(x, y);
        const bool front = hash & 1;
        const float along = Unit(Mixed(hash)) * (front ? 0.15f : 1.0f);
        PlaneHypothesis plane;
        plane.inverse_depth = nearest + (farthest - nearest) * along;
        const float* slope = bounds.slope.at(x, y);
        const float spread = plane.inverse_depth / static_cast<float>(camera.fx);
        plane.gx = front ? slope[0] : spread * (2 * Unit(Mixed(hash + 1)) - 1);
        plane.gy = front ? slope[1] : spread * (2 * Unit(Mixed(hash + 2)) - 1);
        maps_[i].SetPlane(index, plane);
        maps_[i].SetSources(index, all);
        maps_[i].SetCost(index, 2 * kWorstCost);  // not computed yet, but readable
      }
    if (!seeds_.empty()) PlantSeeds(i, level);
  }

  void PlantSeeds(int i, int level) {
    const Pinhole& camera = views_[i].camera(level);
    PlaneMap& map = maps_[i];
    for (const Eigen::Vector3d& seed : seeds_[i]) {
      const Eigen::Vector3d x = views_[i].camera_from_world * seed;
      if (x.z() <= 0) continue;
      const Eigen::Vector2d p = camera.Project(x);
      const int px = static_cast<int>(std::lround(p.x())),
                py = static_cast<int>(std::lround(p.y()));
      if (px < 0 || py < 0 || px >= map.width || py >= map.height) continue;
      const float w = static_cast<float>(1 / x.z());
      const std::size_t pixel = static_cast<std::size_t>(py) * map.width + px;
      PlaneHypothesis plane = map.Plane(pixel);
      if (plane.inverse_depth <= 0 || w > *bounds_[i].nearest.at(px, py) ||
          w < *bounds_[i].farthest.at(px, py))
        continue;
      plane.inverse_depth = w;
      map.SetPlane(pixel, plane);
    }
  }

  // Each fine pixel inherits the plane of the coarse pixel that covers it.
  void Descend(int i, int level) {
    const SweepInputs inputs = Inputs(i, level);
    const Pinhole& camera = views_[i].camera(level);
    PlaneMap coarse = std::move(maps_[i]);
    coarse.Unpack();
    PlaneMap fine(camera, SizeOf(sources_[i]));
    DepthImage prior = NoDepths(i, level + 1);
    for (std::size_t k = 0; k < coarse.size(); ++k) prior.Set(k, coarse.InverseDepth(k));
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        if (!Visited(inputs, x, y)) continue;
        const std::size_t index = static_cast<std::size_t>(y) * camera.width + x;
        const int parent = BestParent(coarse, x, y);
        if (parent < 0) continue;
        const PlaneHypothesis from = coarse.Plane(parent);
        const float px = static_cast<float>(parent % coarse.width) * 2 + 0.5f,
                    py = static_cast<float>(parent / coarse.width) * 2 + 0.5f;
        PlaneHypothesis plane = {
            from.inverse_depth + 0.5f * (from.gx * (x - px) + from.gy * (y - py)), from.gx * 0.5f,
            from.gy * 0.5f};
        if (!(plane.inverse_depth > 0)) plane.inverse_depth = from.inverse_depth;
        fine.SetSources(index, coarse.Sources(parent));
        fine.SetPlane(index, plane);
        fine.SetCost(index, 2 * kWorstCost);
      }
    maps_[i] = std::move(fine);
    priors_[i] = std::move(prior);
  }

  // The pixel's own parent. At the mask's border, where that was not in the mask, the best of the
  // parents around.
  static int BestParent(const PlaneMap& coarse, int x, int y) {
    const int cx = std::min(x / 2, coarse.width - 1), cy = std::min(y / 2, coarse.height - 1);
    if (coarse.InverseDepth(static_cast<std::size_t>(cy) * coarse.width + cx) > 0)
      return cy * coarse.width + cx;
    int best = -1;
    for (int ny = std::max(0, cy - 1); ny <= std::min(coarse.height - 1, cy + 1); ++ny)
      for (int nx = std::max(0, cx - 1); nx <= std::min(coarse.width - 1, cx + 1); ++nx) {
        const int k = ny * coarse.width + nx;
        if (coarse.InverseDepth(k) > 0 && (best < 0 || coarse.Cost(k) < coarse.Cost(best)))
          best = k;
      }
    return best;
  }

  const std::vector<PreparedView>& views_;
  const std::vector<std::vector<int>>& sources_;
  const std::vector<DepthBounds>& bounds_;
  const std::vector<std::vector<Eigen::Vector3d>>& seeds_;
  const PatchMatchOptions& options_;
  Progress* progress_;
  int levels_ = 0;
  double work_ = 0, total_work_ = 0;
  std::vector<PlaneMap> maps_;
  std::vector<DepthImage> inverse_depths_, priors_;
  std::unique_ptr<SampleCache> samples_;
  std::vector<std::int64_t> evaluations_;
};

}  // namespace

PatchMatchResult EstimatePlanes(const std::vector<PreparedView>& views,
                                const std::vector<std::vector<int>>& sources,
                                const std::vector<DepthBounds>& bounds,
                                const std::vector<std::vector<Eigen::Vector3d>>& seeds,
                                const PatchMatchOptions& options, Progress* progress) {
  return Estimator(views, sources, bounds, seeds, options, progress).Run();
}

}  // namespace keypose::stereo
