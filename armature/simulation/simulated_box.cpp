#include "armature/simulation/simulated_box.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/values/angles.h"

namespace keypose::armature {

namespace {

constexpr int kInputsOfACard = 16;

/// As many full cards as needed, the last with as many inputs as are left.
std::vector<keypose_box::Card> CardsFor(int sensors) {
  std::vector<keypose_box::Card> cards;
  for (int left = sensors; left > 0; left -= kInputsOfACard)
    cards.push_back(
        {keypose_box::kEncoders, static_cast<std::uint8_t>(std::min(left, kInputsOfACard))});
  return cards;
}

std::chrono::steady_clock::duration Seconds(double seconds) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(seconds));
}

}  // namespace

SimulatedBox::SimulatedBox(const Armature& armature, const std::filesystem::path& link,
                           const SimulationOptions& options)
    : armature_(armature),
      options_(options),
      link_(link),
      sensors_(armature, options.gears),
      values_(armature.joints.size()),
      targets_(armature.joints.size()),
      cards_(CardsFor(armature.sensor_count())),
      boot_(options.boot - 1) {
  PowerUp();
  for (const PlannedFault& fault : options_.faults)
    if (fault.kind == FaultKind::kWrap) sensors_.GoNearTheEnds();
  terminal_.Open(link_);
  thread_ = std::thread([this] { Run(); });
}

SimulatedBox::~SimulatedBox() {
  ends_ = true;
  thread_.join();
  terminal_.Close();
  std::error_code ignored;
  std::filesystem::remove(link_, ignored);
}

void SimulatedBox::PowerUp() {
  sensors_.LosePower();
  box_ = std::make_unique<keypose_box::Box>(sensors_, wire_, cards_.data(),
                                            static_cast<std::uint8_t>(cards_.size()),
                                            static_cast<std::uint16_t>(++boot_));
}

void SimulatedBox::SetValues(const std::vector<double>& values) {
  const std::lock_guard lock(mutex_);
  values_ = targets_ = values;
  sensors_.SetValues(values);
}

void SimulatedBox::MoveTo(const std::vector<double>& values) {
  const std::lock_guard lock(mutex_);
  targets_ = values;
}

bool SimulatedBox::at_rest() const {
  const std::lock_guard lock(mutex_);
  return values_ == targets_;
}

void SimulatedBox::Turn(double passed_s) {
  if (values_ == targets_) return;
  for (std::size_t j = 0; j < values_.size(); ++j) {
    const ArmatureNode& node = armature_.nodes[static_cast<std::size_t>(armature_.joints[j])];
    const double turn = node.kind == NodeKind::kSlide ? 1 : 2 * kPi;
    const double most = options_.speed_rev_s * passed_s * turn / std::abs(node.scale);
    const double way = targets_[j] - values_[j];
    values_[j] = std::abs(way) <= most ? targets_[j] : values_[j] + std::copysign(most, way);
  }
  sensors_.SetValues(values_);
}

void SimulatedBox::BeginFrame(int frame) {
  std::vector<PlannedFault> due;
  {
    const std::lock_guard lock(mutex_);
    const auto later =
        std::stable_partition(options_.faults.begin(), options_.faults.end(),
                              [&](const PlannedFault& fault) { return fault.frame != frame; });
    due.assign(later, options_.faults.end());
    options_.faults.erase(later, options_.faults.end());
  }
  for (const PlannedFault& fault : due) Make(fault);
}

void SimulatedBox::Make(const PlannedFault& fault) {
  const std::lock_guard lock(mutex_);
  const auto now = Clock::now();
  switch (fault.kind) {
    case FaultKind::kDrop:
      drops_until_ = now + Seconds(options_.disturbed_s);
      break;
    case FaultKind::kNoise:
      noise_until_ = now + Seconds(options_.disturbed_s);
      break;
    case FaultKind::kGlitch:
      sensors_.SetGlitch(fault.sensor, 1 << 20);
      glitched_ = fault.sensor;
      glitch_until_ = now + Seconds(options_.disturbed_s);
      break;
    case FaultKind::kWrap:
      break;  // from the start
    case FaultKind::kStuck:
      sensors_.SetStuck(fault.sensor, true);
      break;
    case FaultKind::kLost:
      sensors_.LosePower(fault.sensor);
      break;
    case FaultKind::kUnplug:
      out_until_ = now + Seconds(options_.unplugged_s);
      break;
    case FaultKind::kPower:
      PowerUp();
      break;
  }
}

void SimulatedBox::Mend(int sensor) {
  const std::lock_guard lock(mutex_);
  sensors_.SetStuck(sensor, false);
}

void SimulatedBox::Run() {
  auto last = Clock::now();
  while (!ends_) {
    const std::string received = terminal_.Read(0.005);
    const std::lock_guard lock(mutex_);
    const auto now = Clock::now();
    EndOldFaults(now);
    Turn(std::chrono::duration<double>(now - last).count());
    last = now;
    Serve(received);
  }
}

void SimulatedBox::EndOldFaults(Clock::time_point now) {
  if (glitched_ >= 0 && now >= glitch_until_) {
    sensors_.SetGlitch(glitched_, 0);
    glitched_ = -1;
  }
  // Only this thread touches the terminal.
  if (now < out_until_)
    terminal_.Close();
  else if (!terminal_.is_open())
    terminal_.Open(link_);
}

std::string SimulatedBox::Disturbed(std::string bytes) {
  const auto now = Clock::now();
  if (now < drops_until_) std::erase_if(bytes, [&](char) { return random_() % 8 == 0; });
  if (now < noise_until_)
    for (char& byte : bytes)
      if (random_() % 16 == 0) byte = static_cast<char>(random_());
  return bytes;
}

void SimulatedBox::Serve(const std::string& received) {
  const auto now = Clock::now();
  if (received.empty()) {
    if (now - last_byte_ > std::chrono::milliseconds(20)) box_->LineIsQuiet();
    return;
  }
  last_byte_ = now;
  for (const char byte : Disturbed(received)) box_->Take(static_cast<std::uint8_t>(byte));
  terminal_.Write(Disturbed(std::exchange(wire_.bytes, {})));
}

}  // namespace keypose::armature
