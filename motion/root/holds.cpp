#include "motion/root/holds.h"

#include <algorithm>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::motion {

namespace {

constexpr double kPinRadius = 0.02;  // of the diagonal: pins on single vertices make cusps

std::vector<int> VerticesAround(const PointsX3& points, const FacesX3& faces,
                                const MarkPlace& place) {
  const Eigen::RowVector3d centre = PositionOf(place, points, faces);
  const double radius = kPinRadius * BoundingDiagonal(points);
  std::vector<int> around = {faces(place.face, 0), faces(place.face, 1), faces(place.face, 2)};
  for (int i = 0; i < static_cast<int>(points.rows()); ++i)
    if ((points.row(i) - centre).norm() < radius) around.push_back(i);
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  return around;
}

}  // namespace

Holds::Holds(const PointsX3& target, const FacesX3& faces, const std::vector<Mark>& marks,
             const PointsX3& reference, const FacesX3& template_faces,
             const std::function<Eigen::RowVector3d(const Eigen::RowVector3d&)>& to_target,
             const std::vector<Pin>& pins, bool feet)
    : target_(target),
      faces_(faces),
      marks_(marks),
      template_height_(reference.col(2).maxCoeff() - reference.col(2).minCoeff()),
      ground_(target.col(2).minCoeff()),
      diagonal_(BoundingDiagonal(target)) {
  if (feet) {
    const std::vector<SolePatch> on_target = FindSoles(target, faces),
                                 on_template = FindSoles(reference, template_faces);
    const std::vector<int> pairs =
        PairSoles(on_template, on_target, to_target, target.col(2).maxCoeff() - ground_);
    for (int p = 0; p < SizeOf(on_target); ++p)
      if (pairs[p] >= 0) soles_.push_back({on_target[p], on_template[pairs[p]], {}, {}, {}, {}});
  }
  report_.soles = SizeOf(soles_);
  for (const Pin& pin : pins) {
    const auto mark =
        std::find_if(marks.begin(), marks.end(), [&](const Mark& m) { return m.name == pin.mark; });
    if (mark == marks.end())
      throw InputError("transfer: a pin names the mark '" + pin.mark +
                       "', which the marks do not have");
    if (pin.first < 0 || pin.last < pin.first)
      throw InputError("transfer: the pin of '" + pin.mark + "' goes from frame " +
                       std::to_string(pin.first) + " to " + std::to_string(pin.last) +
                       "; frames count from 0, and the first must not be after the last");
    pins_.push_back({pin, mark->on_target, VerticesAround(target, faces, mark->on_target), {}, {}});
  }
  const auto when = ThreadCount() > 1 ? std::launch::async : std::launch::deferred;
  if (any()) copy_ = std::async(when, [this] { return CopyOf(target_, faces_); });
}

void Holds::Watch(const PointsX3& frame) {
  for (const Sole& sole : soles_) {
    Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
    double lowest = std::numeric_limits<double>::infinity();
    for (int i : sole.on_template.vertices) {
      centre += frame.row(i) / static_cast<double>(sole.on_template.vertices.size());
      lowest = std::min(lowest, frame(i, 2));
    }
    centres_seen_.push_back(centre);
    lowest_seen_.push_back(lowest);
  }
}

void Holds::PlanSoles(const std::vector<PointsX3>& tracks, double fps,
                      std::vector<MotionFrame>& motion) {
  const int frames = SizeOf(motion), count = SizeOf(soles_);
  std::vector<SoleTrack> on_target(count);
  std::vector<std::vector<char>> contacts(count);
  std::vector<double> heights(count);
  for (int p = 0; p < count; ++p) {
    SoleTrack on_template{PointsX3(frames, 3), Eigen::VectorXd(frames)};
    for (int t = 0; t < frames; ++t) {
      on_template.centres.row(t) = centres_seen_[t * count + p];
      on_template.lowest[t] = lowest_seen_[t * count + p];
    }
    contacts[p] = FindContacts(on_template, template_height_, fps);
    on_target[p].centres = tracks[p];
    heights[p] = soles_[p].on_target.centre[2];
    for (int t = 0; t < frames; ++t)
      report_.contacts += contacts[p][t] && (t == 0 || !contacts[p][t - 1]);
  }
  if (report_.contacts == 0) return;
  FootPlan plan = PlanFeet(on_target, contacts, heights);
  for (int t = 0; t < frames; ++t) motion[t].root += plan.shift.row(t);
  report_.root_shift = plan.shift.rowwise().norm().maxCoeff();
  for (int p = 0; p < count; ++p) {
    soles_[p].contact = contacts[p];
    soles_[p].places = tracks[p] + plan.shift + plan.holds[p].moves;
    soles_[p].hold = std::move(plan.holds[p]);
  }
}

void Holds::PlanPin(Pinned& pinned, const PointsX3& track) {
  const Pin& pin = pinned.pin;
  if (pin.last >= track.rows())
    throw InputError("transfer: the pin of '" + pin.mark + "' ends at frame " +
                     std::to_string(pin.last) + ", but the motion has " +
                     std::to_string(track.rows()) + " frames");
  std::vector<char> held(track.rows(), 0);
  std::fill(held.begin() + pin.first, held.begin() + pin.last + 1, 1);
  pinned.at = pin.at ? *pin.at : Eigen::RowVector3d(track.row(pin.first));
  pinned.hold = HoldRuns(track, held, [&](int, int) { return pinned.at; });
}

void Holds::Plan(const PoissonSystem& system, const RootPath& path, double fps,
                 std::vector<MotionFrame>& frames) {
  if (!any() || frames.empty()) return;
  for (std::size_t a = 0; a < pins_.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (pins_[a].pin.mark == pins_[b].pin.mark && pins_[a].pin.first <= pins_[b].pin.last &&
          pins_[b].pin.first <= pins_[a].pin.last)
        throw InputError("transfer: two pins hold the mark '" + pins_[a].pin.mark +
                         "' at the same time; let one end before the other begins");
  PointsX3 centres(std::ssize(soles_) + std::ssize(pins_), 3);
  std::vector<HeldPatch> patches;
  for (const Sole& sole : soles_) {
    centres.row(std::ssize(patches)) = sole.on_target.centre;
    patches.push_back(PatchOf(sole.on_target.vertices));
  }
  for (const Pinned& pinned : pins_) {
    const MarkPlace& place = pinned.place;
    centres.row(std::ssize(patches)) = PositionOf(place, target_, faces_);
    patches.push_back({pinned.vertices, {}});
    for (int c = 0; c < 3; ++c)
      patches.back().centre.emplace_back(faces_(place.face, c), place.barycentric[c]);
  }
  patches_.emplace(system, patches);
  std::vector<PointsX3> tracks =
      TrackPatches(copy_.get(), target_, faces_, marks_, centres, frames, path);
  std::vector<Eigen::RowVector3d> before;
  for (const MotionFrame& frame : frames) before.push_back(frame.root);
  if (!soles_.empty()) PlanSoles(tracks, fps, frames);
  for (int k = 0; k < SizeOf(pins_); ++k) {
    PointsX3& track = tracks[soles_.size() + k];
    for (Eigen::Index t = 0; t < track.rows(); ++t) track.row(t) += frames[t].root - before[t];
    PlanPin(pins_[k], track);
  }
}

std::vector<HeldPatches::Goal> Holds::GoalsOf(int frame, const PointOf& point_of) const {
  std::vector<HeldPatches::Goal> goals;
  if (!patches_) return goals;
  for (int p = 0; p < SizeOf(soles_); ++p) {
    const Sole& sole = soles_[p];
    if (sole.contact.empty()) continue;
    const double firmness = sole.hold.firmness[frame];
    if (firmness == 1) {
      goals.push_back({p, sole.places.row(frame)});
      continue;
    }
    Eigen::RowVector3d move = sole.hold.moves.row(frame);
    double lowest = std::numeric_limits<double>::infinity();
    for (int i : sole.on_target.vertices) lowest = std::min(lowest, point_of(i)[2]);
    const double sinks = ground_ - lowest - move[2];
    if (sinks > 0) move[2] += sinks;
    if (firmness > 0 || sinks > 0) goals.push_back({p, patches_->CentreOf(p, point_of) + move});
  }
  for (int k = 0; k < SizeOf(pins_); ++k) {
    const int patch = SizeOf(soles_) + k;
    const double firmness = pins_[k].hold.firmness[frame];
    if (firmness == 1)
      goals.push_back({patch, pins_[k].at});
    else if (firmness > 0)
      goals.push_back(
          {patch, patches_->CentreOf(patch, point_of) + pins_[k].hold.moves.row(frame)});
  }
  return goals;
}

}  // namespace keypose::motion
