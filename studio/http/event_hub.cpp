#include "studio/http/event_hub.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

namespace keypose::studio {
namespace {

/// A tab that slept longer than this many events loads everything again anyway.
constexpr std::size_t kKept = 2000;
constexpr auto kSilence = std::chrono::seconds(5);

}  // namespace

void EventHub::Send(const std::string& type, const std::string& data) {
  const std::lock_guard<std::mutex> lock(mutex_);
  events_.push_back(fmt::format("event: {}\ndata: {}\n\n", type, data));
  ++end_;
  if (events_.size() > kKept) events_.pop_front();
  wake_.notify_all();
}

void EventHub::Close() {
  const std::lock_guard<std::mutex> lock(mutex_);
  closed_ = true;
  wake_.notify_all();
}

void EventHub::Count(int change) {
  int tabs = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    tabs = tabs_ += change;
  }
  Send("writers", fmt::format("{{\"count\": {}}}", tabs));
}

EventHub::Tab::Tab(EventHub& hub) : hub_(hub) {
  {
    const std::lock_guard<std::mutex> lock(hub_.mutex_);
    next_ = hub_.end_;
  }
  hub_.Count(1);
}

EventHub::Tab::~Tab() { hub_.Count(-1); }

std::string EventHub::Tab::Next() {
  std::unique_lock<std::mutex> lock(hub_.mutex_);
  hub_.wake_.wait_for(lock, kSilence, [&] { return hub_.closed_ || hub_.end_ > next_; });
  if (hub_.closed_) return "";
  std::string text;
  const std::uint64_t first = hub_.end_ - hub_.events_.size();
  for (next_ = std::max(next_, first); next_ < hub_.end_; ++next_)
    text += hub_.events_[static_cast<std::size_t>(next_ - first)];
  return text.empty() ? ": still here\n\n" : text;
}

}  // namespace keypose::studio
