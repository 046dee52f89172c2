#include "capture/shoot/simulation/simulated_world.h"

#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {

using nlohmann::json;

SimulatedWorld::SimulatedWorld(const std::filesystem::path& file) : file_(file) {
  if (file_.empty() || !std::filesystem::exists(file_)) return;
  try {
    const json root = json::parse(ReadFile(file_));
    table_deg_ = root.at("table_deg");
    ring_ = root.at("ring");
    flip_ = root.at("flip");
    pose_ = root.at("pose");
  } catch (const json::exception& error) {
    throw InputError(file_.string() + " is damaged (" + JsonFault(error) + "); remove it");
  }
}

double SimulatedWorld::table_deg() const {
  const std::lock_guard lock(mutex_);
  return table_deg_;
}

int SimulatedWorld::ring() const {
  const std::lock_guard lock(mutex_);
  return ring_;
}

int SimulatedWorld::flip() const {
  const std::lock_guard lock(mutex_);
  return flip_;
}

std::string SimulatedWorld::pose() const {
  const std::lock_guard lock(mutex_);
  return pose_;
}

void SimulatedWorld::SetTable(double angle_deg) {
  const std::lock_guard lock(mutex_);
  table_deg_ = angle_deg;
  Save();
}

void SimulatedWorld::SetCamera(int ring) {
  const std::lock_guard lock(mutex_);
  ring_ = ring;
  Save();
}

void SimulatedWorld::SetFigure(const std::string& pose, int flip) {
  const std::lock_guard lock(mutex_);
  pose_ = pose;
  flip_ = flip;
  Save();
}

void SimulatedWorld::Save() const {
  if (file_.empty()) return;
  const json root = {{"table_deg", table_deg_}, {"ring", ring_}, {"flip", flip_}, {"pose", pose_}};
  WriteFileAtomically(file_, root.dump() + "\n");
}

}  // namespace keypose::capture::shoot
