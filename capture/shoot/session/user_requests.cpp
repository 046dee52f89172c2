#include "capture/shoot/session/user_requests.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "capture/shoot/session/project.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {

void UserRequests::Wait(double seconds) {
  const double until = Now() + seconds;
  do {
    const auto command = talk_.Hear(std::clamp(until - Now(), 0.0, 0.05));
    if (command) Handle(*command);
    if (holds_ > 0) continue;
    if (talk_.Interrupted()) throw Cancelled();
    if (ending_) throw EndAsked{};
    if (rethink_) {
      rethink_ = false;
      throw Rethink{};
    }
  } while (Now() < until);
}

void UserRequests::Handle(const Command& command) {
  std::string refusal;
  switch (command.kind) {
    case Command::Kind::kGoOn:
      done = true;
      paused = false;
      break;
    case Command::Kind::kPause:
      paused = rethink_ = true;
      break;
    case Command::Kind::kEnd:
      ending_ = true;
      break;
    case Command::Kind::kLive:
      live = command.on;
      break;
    case Command::Kind::kAgain:
      refusal = WantAgain(command);
      break;
    case Command::Kind::kSkip:
      refusal = Skip(command);
      break;
    case Command::Kind::kAt:
      refusal = TableIsAt(command);
      break;
    case Command::Kind::kNextPose:
      refusal = NextPose(command);
      break;
  }
  announcer_.Answer(command, refusal);
}

std::string UserRequests::WantAgain(const Command& command) {
  const ShotPlan& plan = book_->side().plan;
  std::optional<Shot> shot = ShotNamed(plan, command.photograph);
  std::optional<double> angle_deg = command.angle_deg;
  if (!shot && !angle_deg && !command.photograph.empty()) {
    char* end = nullptr;
    const double number = std::strtod(command.photograph.c_str(), &end);
    if (*end == 0) angle_deg = number;
  }
  if (!shot && angle_deg)
    shot = ShotAt(plan, command.flip.value_or(target.flip), command.ring.value_or(target.ring),
                  *angle_deg);
  if (!shot) return "no photograph of the plan has this name or angle";
  again.push_back(*shot);
  paused = false;
  rethink_ = true;
  return "";
}

std::string UserRequests::TableIsAt(const Command& command) {
  const double angle_deg = command.angle_deg.value_or(NAN);
  if (!std::isfinite(angle_deg) || std::abs(angle_deg) >= 1e6) return "that is no angle";
  table_is_at_deg = angle_deg;
  rethink_ = true;
  return "";
}

std::string UserRequests::NextPose(const Command& command) {
  if (!IsPoseName(command.pose)) return "a pose's name may have letters, digits, '-' and '_' only";
  if (command.angles) {
    ShotPlan plan;
    plan.angles = *command.angles;
    if (const auto problems = plan.Problems(); !problems.empty()) return problems.front();
  }
  next_pose = command.pose;
  next_angles = command.angles;
  rethink_ = true;
  return "";
}

std::string UserRequests::Skip(const Command& command) {
  Shot shot = target;
  if (!command.photograph.empty()) {
    const auto named = ShotNamed(book_->side().plan, command.photograph);
    if (!named) return "no photograph of the plan has this name";
    shot = *named;
  } else if (checking) {
    skip_check = rethink_ = true;
    return "";
  } else if (!again.empty()) {
    again.pop_front();
    rethink_ = true;
    return "";
  }
  if (book_->Has(shot)) return "this photograph is there already";
  book_->Skip(shot);
  book_->Save();
  rethink_ = true;
  return "";
}

}  // namespace keypose::capture::shoot
