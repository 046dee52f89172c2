// How an algorithm reports its progress and learns that it should stop.
#pragma once

#include <string_view>

#include "core/values/errors.h"

namespace keypose {

/// Receives progress. Algorithms take a pointer that may be null; they call `ReportProgress` once
/// per outer iteration.
class Progress {
 public:
  virtual ~Progress() = default;
  /// May be called by several threads at a time.
  /// @param fraction  of the whole stage, in [0,1]
  /// @param what      a few words for a person
  virtual void Update(double fraction, std::string_view what) = 0;
  virtual bool cancelled() const { return false; }
};

/// Reports progress; does nothing when `progress` is null.
/// @throws Cancelled  the user asked to stop
inline void ReportProgress(Progress* progress, double fraction, std::string_view what) {
  if (!progress) return;
  if (progress->cancelled()) throw Cancelled();
  progress->Update(fraction, what);
}

/// Maps the progress [0,1] of a part of the work to [begin,end] of the whole.
class SubProgress final : public Progress {
 public:
  SubProgress(Progress* whole, double begin, double end)
      : whole_(whole), begin_(begin), end_(end) {}
  void Update(double fraction, std::string_view what) override {
    if (whole_) whole_->Update(begin_ + (end_ - begin_) * fraction, what);
  }
  bool cancelled() const override { return whole_ && whole_->cancelled(); }

 private:
  Progress* whole_;
  double begin_, end_;
};

}  // namespace keypose
