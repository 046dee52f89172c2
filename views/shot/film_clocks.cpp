#include "views/shot/film_clocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "views/clocks/sound_onsets.h"
#include "views/decode/film_motion.h"
#include "views/decode/film_sound.h"

namespace keypose {
namespace {

constexpr double kMostSound_s = 3600, kMostMotion_s = 300;
constexpr double kMotionGrid = 240;       // per second
constexpr double kSoundTravels_s = 0.02;  // seven metres
constexpr double kMotionPictures = 1.5;   // other views of one movement differ by so much
constexpr double kMostDrift = 2e-3;

constexpr OffsetOptions kSound{
    .trend_s = 0.5, .apart_s = 0.05, .least_peak = 0.2, .least_ratio = 1.4, .least_sigmas = 8};
constexpr OffsetOptions kMotion{.trend_s = 2, .apart_s = 0.25, .least_peak = 0.5};

double SlowestPicture_s(const std::vector<const ShotCamera*>& films) {
  double longest = 0;
  for (const ShotCamera* film : films)
    longest = std::max(longest, 1 / film->pictures.index->rate.per_second);
  return longest;
}

Signal SoundOf(const ShotCamera& film, const Progress* progress) {
  const FilmSound sound =
      ReadFilmSound(film.pictures.video, *film.pictures.index, kMostSound_s, progress);
  return SoundOnsets({sound.first_s, sound.per_milli});
}

Signal MotionOf(const ShotCamera& film, const Progress* progress) {
  const FilmMotion motion =
      ReadFilmMotion(film.pictures.video, *film.pictures.index, kMostMotion_s, progress);
  return motion.values.empty() ? Signal{0, kMotionGrid, {}}
                               : Resampled(motion.times_s, motion.values, kMotionGrid);
}

/// Compares films pair by pair.
class Comparing {
 public:
  Comparing(const std::vector<const ShotCamera*>& films, const Progress* progress)
      : films_(films), progress_(progress), picture_s_(SlowestPicture_s(films)) {}

  FilmClocks Find() {
    Compare(SoundOf, kSound);
    by_sound_ = links_.size();
    sound_ = Joined();
    if (!sound_) Compare(MotionOf, kMotion);
    if (!Joined()) return Unjoined();
    const double least_drift_s = (sound_ ? 0.5 : 1) * picture_s_;
    const ClockNetwork network = SolveClocks(SizeOf(films_), links_, least_drift_s);
    if (network.worst_s > picture_s_) return Contradicted(network);
    RequireLittleDrift(network);
    return Told(network);
  }

 private:
  bool Joined() const {
    const std::vector<int> groups = LinkedGroups(SizeOf(films_), links_);
    return *std::max_element(groups.begin(), groups.end()) == 0;
  }

  /// All pairs that are not joined yet.
  void Compare(Signal (*signal_of)(const ShotCamera&, const Progress*),
               const OffsetOptions& options) {
    std::vector<Signal> signals(films_.size());
    ParallelFor(SizeOf(films_),
                [&](std::int64_t f) { signals[f] = signal_of(*films_[f], progress_); });
    const std::vector<int> groups = LinkedGroups(SizeOf(films_), links_);
    std::vector<ClockLink> pairs;
    for (int a = 0; a < SizeOf(films_); ++a)
      for (int b = a + 1; b < SizeOf(films_); ++b)
        if (groups[a] != groups[b] && !signals[a].values.empty() && !signals[b].values.empty())
          pairs.push_back({a, b, {}});
    ParallelFor(SizeOf(pairs), [&](std::int64_t p) {
      if (progress_ && progress_->cancelled()) throw Cancelled();
      pairs[p].drift = CorrelateDrifting(signals[pairs[p].a], signals[pairs[p].b], options);
    });
    std::vector<ClockLink> likely;
    for (const ClockLink& pair : pairs)
      (pair.drift.whole.likely ? likely : unclear_).push_back(pair);
    const std::vector<bool> confirmed = ConfirmedByThird(likely, picture_s_);
    for (std::size_t l = 0; l < likely.size(); ++l)
      (likely[l].drift.whole.confident || confirmed[l] ? links_ : unclear_).push_back(likely[l]);
  }

  /// How exactly offsets are told.
  double Least_s() const {
    return sound_ ? std::max(0.5 * picture_s_, kSoundTravels_s) : kMotionPictures * picture_s_;
  }
  std::string How() const { return sound_ ? "sound" : "what moves in them"; }

  std::string PairText(const ClockLink& pair) const {
    const ClockOffset& offset = pair.drift.whole;
    return fmt::format("{} against {}: correlation {:.2f}, elsewhere {:.2f}", films_[pair.b]->name,
                       films_[pair.a]->name, offset.peak, offset.second_peak);
  }

  FilmClocks Unjoined() const {
    std::string best = "none has sound or enough pictures";
    const auto clearest = std::max_element(
        unclear_.begin(), unclear_.end(),
        [](const auto& a, const auto& b) { return a.drift.whole.sigmas < b.drift.whole.sigmas; });
    if (clearest != unclear_.end()) best = "the clearest is camera " + PairText(*clearest);
    for (std::size_t l = 0; l < by_sound_; ++l)
      if (std::abs(links_[l].drift.whole.seconds) > Least_s()) RefuseUnjoined(links_[l], best);
    return {{},
            {"the films are joined by their time stamps alone: neither sound nor motion clearly "
             "tells offsets between the cameras' clocks (" +
             best + ")"}};
  }
  [[noreturn]] void RefuseUnjoined(const ClockLink& link, const std::string& best) const {
    const std::vector<int> groups = LinkedGroups(SizeOf(films_), links_);
    std::vector<std::string> lone;
    for (int f = 0; f < SizeOf(films_); ++f)
      if (groups[f] != groups[link.a]) lone.push_back(films_[f]->name);
    const double seconds = link.drift.whole.seconds;  // above 0: b began first
    throw InputError(fmt::format(
        "the clocks of cameras {} and {} differ by {:.3f} s, but neither sound nor motion tells "
        "that of {} ({}); say when each film began, in the order of the cameras' names (of {} and "
        "{} clock_offsets: {:.3f},{:.3f}), or keep the time stamps by clock_offsets: off; next "
        "time clap once where all cameras film",
        films_[link.a]->name, films_[link.b]->name, seconds, fmt::join(lone, ", "), best,
        films_[link.a]->name, films_[link.b]->name, std::max(0.0, seconds),
        std::max(0.0, -seconds)));
  }

  FilmClocks Contradicted(const ClockNetwork& network) const {
    const ClockLink& worst = links_[network.worst_link];
    return {
        {},
        {fmt::format("the films are joined by their time stamps alone: the offsets that {} "
                     "tells contradict each other by {:.0f} ms (cameras {} and {})",
                     How(), 1000 * network.worst_s, films_[worst.a]->name, films_[worst.b]->name)}};
  }

  void RequireLittleDrift(const ClockNetwork& network) const {
    for (int f = 0; f < SizeOf(films_); ++f)
      if (std::abs(network.clocks[f].rate - 1) > kMostDrift)
        throw InputError(fmt::format(
            "the clock of camera {} runs {:.2f} % {} than that of {}, by {}: its film was not "
            "copied at the rate it was filmed at; export it again, or keep the time stamps by "
            "clock_offsets: off",
            films_[f]->name, 100 * std::abs(1 / network.clocks[f].rate - 1),
            network.clocks[f].rate < 1 ? "faster" : "slower", films_[0]->name, How()));
  }

  FilmClocks Told(const ClockNetwork& network) const {
    double latest_s = 0;
    bool drifts = false;
    std::string text;
    for (int f = 0; f < SizeOf(films_); ++f) {
      const FilmClock& clock = network.clocks[f];
      latest_s = std::max(latest_s, clock.begin_s);
      drifts = drifts || clock.rate != 1;
      text += fmt::format("{}{} at {:.3f} s", f > 0 ? ", " : "", films_[f]->name, clock.begin_s);
      if (clock.rate != 1) text += fmt::format(" ({:+.0f} ppm)", 1e6 * (1 / clock.rate - 1));
    }
    if (!drifts && latest_s <= Least_s())
      return {{},
              {fmt::format("the films' clocks agree: by {} they differ by {:.0f} ms, less than the "
                           "{:.0f} ms that this can tell",
                           How(), 1000 * latest_s, 1000 * Least_s())}};
    FilmClocks told;
    for (int f = 0; f < SizeOf(films_); ++f) told.clocks[films_[f]->name] = network.clocks[f];
    told.notes.push_back(fmt::format(
        "the films began one after another, by {}: {}; {} pairs of films agree within {:.1f} ms",
        How(), text, links_.size(), 1000 * network.worst_s));
    return told;
  }

  const std::vector<const ShotCamera*>& films_;
  const Progress* progress_;
  double picture_s_;
  bool sound_ = false;        // joins all films
  std::size_t by_sound_ = 0;  // of the links
  std::vector<ClockLink> links_, unclear_;
};

std::vector<const ShotCamera*> Videos(const std::vector<ShotCamera>& cameras) {
  std::vector<const ShotCamera*> films;
  for (const ShotCamera& camera : cameras)
    if (camera.pictures.index) films.push_back(&camera);
  return films;
}

}  // namespace

FilmClocks FindFilmClocks(const std::vector<ShotCamera>& cameras, const Progress* progress) {
  const std::vector<const ShotCamera*> films = Videos(cameras);
  const bool all_run = std::all_of(films.begin(), films.end(), [](const ShotCamera* film) {
    return film->pictures.index->rate.per_second > 0;
  });
  const bool pictures = std::any_of(cameras.begin(), cameras.end(), [](const ShotCamera& camera) {
    return !camera.pictures.empty() && !camera.pictures.index;
  });
  // Numbered pictures have no times that could be moved.
  if (films.size() < 2 || !all_run || pictures) return {};
  return Comparing(films, progress).Find();
}

FilmClocks GivenFilmClocks(const std::vector<ShotCamera>& cameras, const ClockWish& wish) {
  const std::vector<const ShotCamera*> films = Videos(cameras);
  FilmClocks given;
  if (wish.named.empty() && wish.begins_s.size() != films.size())
    throw UsageError(fmt::format("--clock_offsets has {} numbers, but there are {} films",
                                 wish.begins_s.size(), films.size()));
  for (std::size_t f = 0; f < films.size(); ++f) {
    const std::string& name = films[f]->name;
    if (wish.named.empty()) {
      given.clocks[name] = {wish.begins_s[f], 1};
      continue;
    }
    const auto found = wish.named.find(name);
    if (found == wish.named.end())
      throw InputError("the clocks that were found for this shot have none of camera " + name +
                       "; track it again");
    given.clocks[name] = found->second;
  }
  return given;
}

void SetClocks(const std::map<std::string, FilmClock>& clocks, std::vector<ShotCamera>* cameras) {
  for (ShotCamera& camera : *cameras) {
    const auto found = clocks.find(camera.name);
    if (!camera.pictures.index || found == clocks.end()) continue;
    const FilmClock& clock = found->second;
    FilmIndex index = *camera.pictures.index;
    for (double& time : index.times_s) time = clock.rate * time + clock.begin_s;
    index.rate.per_second /= clock.rate;
    camera.pictures.index = std::make_shared<const FilmIndex>(std::move(index));
  }
}

}  // namespace keypose
