#include "views/shot/film_join.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

constexpr double kSlack = 1e-3;        // of half a frame
constexpr double kSameRate = 5e-4;     // relative
constexpr double kWorthSaying = 1e-3;  // s; containers round to milliseconds

/// Videos with pictures among the cameras.
std::vector<ShotCamera*> FilmsAmong(std::vector<ShotCamera>& cameras) {
  std::vector<ShotCamera*> films;
  for (ShotCamera& camera : cameras)
    if (camera.pictures.index) films.push_back(&camera);
  return films;
}

double RateOfFilm(const ShotCamera& film) { return film.pictures.index->rate.per_second; }
const std::vector<double>& TimesOf(const ShotCamera& film) { return film.pictures.index->times_s; }

/// The film of the lowest rate; among equal ones the first without gaps.
const ShotCamera& Slowest(const std::vector<ShotCamera*>& films) {
  const ShotCamera* slowest = films.front();
  for (const ShotCamera* film : films) {
    const double ratio = RateOfFilm(*film) / RateOfFilm(*slowest);
    const bool steadier =
        film->pictures.index->rate.constant && !slowest->pictures.index->rate.constant;
    if (ratio < 1 - kSameRate || (ratio < 1 + kSameRate && steadier)) slowest = film;
  }
  return *slowest;
}

/// The largest difference of the times of pictures of one number [s].
double WorstByNumber(const std::vector<ShotCamera*>& films) {
  std::size_t most = 0;
  for (const ShotCamera* film : films) most = std::max(most, TimesOf(*film).size());
  double worst = 0;
  for (std::size_t i = 0; i < most; ++i) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const ShotCamera* film : films) {
      if (i >= TimesOf(*film).size()) continue;
      low = std::min(low, TimesOf(*film)[i]);
      high = std::max(high, TimesOf(*film)[i]);
    }
    worst = std::max(worst, high - low);
  }
  return worst;
}

bool AllConstant(const std::vector<ShotCamera*>& films) {
  return std::all_of(films.begin(), films.end(),
                     [](const ShotCamera* film) { return film->pictures.index->rate.constant; });
}

std::string RateText(const ShotCamera& film) {
  const PictureRate& rate = film.pictures.index->rate;
  return fmt::format("{} has {:.4g} pictures a second{}", film.name, rate.per_second,
                     rate.constant ? "" : ", some of them missing,");
}

std::string ConvertText(const ShotCamera& film, double rate) {
  return fmt::format("\n  ffmpeg -i {} -vf fps={:.6g} converted.mp4",
                     PrintableName(film.pictures.video.filename()), rate);
}

void RequireNoFolders(const std::vector<ShotCamera>& cameras,
                      const std::vector<ShotCamera*>& films) {
  for (const ShotCamera& camera : cameras) {
    if (camera.pictures.empty() || camera.pictures.index) continue;
    const ShotCamera& slow = Slowest(films);
    throw InputError(fmt::format(
        "the films do not run together ({}), and the numbered pictures of camera {} have no times "
        "by which they could be joined; make all of one rate and one start, as in{}",
        RateText(*films.back()), camera.name, ConvertText(slow, RateOfFilm(slow))));
  }
}

/// Joins films at moments of a constant rate.
class Joining {
 public:
  Joining(std::vector<ShotCamera*> films, FilmGaps gaps, FilmEnds ends)
      : films_(std::move(films)),
        gaps_(gaps),
        ends_(ends),
        slow_(Slowest(films_)),
        frame_s_(1 / RateOfFilm(slow_)) {}

  FilmJoin Join() {
    FindStart();
    std::vector<std::vector<int>> orders(films_.size());
    for (int k = 0; GoesOn(k); ++k) {
      if (gaps_ == FilmGaps::kLeftOut && films_.size() > 1 && IsGap(k)) {
        ++left_out_;
        continue;
      }
      for (std::size_t f = 0; f < films_.size(); ++f) TakePicture(f, k, &orders[f]);
    }
    for (std::size_t f = 0; f < films_.size(); ++f) Apply(std::move(orders[f]), films_[f]);
    return Told();
  }

 private:
  double Moment(int k) const { return start_ + k * frame_s_; }
  /// A film ends when its last picture was shown for a frame.
  bool Reaches(const ShotCamera& film, int k) const {
    return Moment(k) <= TimesOf(film).back() + 0.5 / RateOfFilm(film);
  }
  bool GoesOn(int k) const {
    const auto reaches = [&](const ShotCamera* film) { return Reaches(*film, k); };
    return ends_ == FilmEnds::kCommon ? std::all_of(films_.begin(), films_.end(), reaches)
                                      : std::any_of(films_.begin(), films_.end(), reaches);
  }
  double Distance(const ShotCamera& film, int k) const {
    const FilmIndex& index = *film.pictures.index;
    const int nearest = index.PictureNearest(Moment(k));
    return std::abs(index.times_s[static_cast<std::size_t>(nearest)] - Moment(k));
  }
  bool IsFar(double distance) const { return distance > frame_s_ / 2 * (1 + kSlack); }
  bool IsGap(int k) const {
    return std::any_of(films_.begin(), films_.end(), [&](const ShotCamera* film) {
      return Reaches(*film, k) && IsFar(Distance(*film, k));
    });
  }

  /// The first picture of the slowest camera that is not before all others have begun.
  void FindStart() {
    double begun = -HUGE_VAL, end = HUGE_VAL;
    const ShotCamera* late = nullptr;
    for (const ShotCamera* film : films_) {
      if (TimesOf(*film).front() > begun) late = film;
      begun = std::max(begun, TimesOf(*film).front());
      end = std::min(end, TimesOf(*film).back());
    }
    for (const ShotCamera* film : films_)
      if (TimesOf(*film).back() + frame_s_ / 2 < begun)
        throw InputError(
            fmt::format("the films have no moment in common: {} ends at {:.2f} s, before {} begins "
                        "at {:.2f} s; "
                        "cut them so that all begin together",
                        film->name, TimesOf(*film).back(), late->name, begun));
    const std::vector<double>& times = TimesOf(slow_);
    const auto first = std::lower_bound(times.begin(), times.end(), begun - frame_s_ / 2);
    start_ = first == times.end() ? begun : *first;
  }

  void TakePicture(std::size_t f, int k, std::vector<int>* order) {
    const ShotCamera& film = *films_[f];
    if (!Reaches(film, k)) return;
    const double distance = Distance(film, k);
    if (IsFar(distance)) {
      ++held_;
      if (films_.size() > 1) Refuse(film, k, distance);
    } else if (distance > worst_s_) {
      worst_s_ = distance;
      worst_ = &film;
    }
    const FilmIndex& index = *film.pictures.index;
    order->push_back(films_.size() > 1 ? index.PictureNearest(Moment(k))
                                       : index.PictureAt(Moment(k) + frame_s_ / 2));
  }
  [[noreturn]] void Refuse(const ShotCamera& film, int k, double distance) const {
    throw InputError(fmt::format(
        "the films do not run together: at {:.3f} s camera {} has no picture; its nearest is "
        "{:.1f} "
        "ms away, and half a frame of {}, the slowest, is {:.1f} ms. Take that part out of all "
        "films, or, if little moved, fill its gaps with the pictures before them, as in{}",
        Moment(k), film.name, 1000 * distance, slow_.name, 500 * frame_s_,
        ConvertText(film, RateOfFilm(film))));
  }

  void Apply(std::vector<int> order, ShotCamera* film) const {
    if (order.empty())
      throw InputError(
          fmt::format("the films do not run together: camera {} has no picture within {:.1f} ms of "
                      "those of the "
                      "others; make all of one rate and one start",
                      film->name, 500 * frame_s_));
    const FrameSource masks = film->masks;
    film->pictures.order = std::move(order);
    film->pictures.frames = SizeOf(film->pictures.order);
    film->pictures.frames_per_second = RateOfFilm(slow_);
    TakeMasks(masks, film);
  }

  FilmJoin Told() const {
    FilmJoin join;
    join.frames_per_second = RateOfFilm(slow_);
    join.worst_s = worst_s_;
    std::string rates;
    for (const ShotCamera* film : films_)
      rates += (rates.empty() ? "" : "; ") + RateText(*film) +
               fmt::format(" from {:.3f} s", TimesOf(*film).front());
    std::string text = fmt::format(
        "the films' pictures are taken by their times, {:.4g} a second from {:.3f} s on ({})",
        join.frames_per_second, start_, rates);
    if (worst_)
      text += fmt::format("; a picture lies up to {:.1f} ms from its moment (camera {})",
                          1000 * worst_s_, worst_->name);
    if (left_out_ > 0)
      text += fmt::format("; {} moments are left out, of which a camera has no picture", left_out_);
    if (held_ > 0) text += fmt::format("; {} frames are missing and show the one before", held_);
    join.notes.push_back(text);
    return join;
  }

  std::vector<ShotCamera*> films_;
  FilmGaps gaps_;
  FilmEnds ends_;
  const ShotCamera& slow_;
  double frame_s_, start_ = 0, worst_s_ = 0;
  const ShotCamera* worst_ = nullptr;
  int left_out_ = 0, held_ = 0;
};

}  // namespace

void TakeMasks(const FrameSource& masks, ShotCamera* camera) {
  const FrameSource& film = camera->pictures;
  camera->masks = masks;
  if (film.order.empty() || masks.empty() || masks.frames == film.frames) return;
  if (masks.frames != film.index->frames()) return;
  camera->masks.order = film.order;
  camera->masks.frames = film.frames;
}

FilmJoin JoinFilms(std::vector<ShotCamera>& cameras, FilmGaps gaps, FilmEnds ends) {
  const std::vector<ShotCamera*> films = FilmsAmong(cameras);
  FilmJoin join;
  for (const ShotCamera* film : films) {
    if (!(RateOfFilm(*film) > 0)) return join;  // one picture alone
    join.frames_per_second = std::max(join.frames_per_second, RateOfFilm(*film));
    for (const std::string& note : film->pictures.index->notes)
      join.notes.push_back("the video of camera " + film->name + " " + note);
  }
  if (films.empty()) return join;
  const double half_s = 0.5 / RateOfFilm(Slowest(films));
  join.worst_s = WorstByNumber(films);
  if (AllConstant(films) && join.worst_s <= half_s) {
    if (join.worst_s >= kWorthSaying)
      join.notes.push_back(fmt::format(
          "the films' pictures of one number lie up to {:.1f} ms apart", 1000 * join.worst_s));
    return join;
  }
  RequireNoFolders(cameras, films);
  FilmJoin joined = Joining(films, gaps, ends).Join();
  joined.notes.insert(joined.notes.begin(), join.notes.begin(), join.notes.end());
  return joined;
}

}  // namespace keypose
