// How far apart the clocks of two recordings of one event are.
#pragma once

#include <vector>

namespace keypose {

/// A number at even times.
struct Signal {
  double first_s = 0;     ///< time of values[0], by the recording's own clock
  double per_second = 0;  ///< > 0
  std::vector<double> values;
  double seconds() const { return static_cast<double>(values.size()) / per_second; }
};

struct OffsetOptions {
  double trend_s = 2;          ///< what changes slower than this tells nothing
  double least_overlap_s = 2;  ///< in common, or half of the shorter signal
  double apart_s = 0.1;        ///< peaks nearer than this to the highest are the same one
  double least_peak = 0.3;     ///< correlation, in (0, 1]
  double least_ratio = 1.3;    ///< of the highest peak over the next one
  double least_sigmas = 6;  ///< of the highest peak (its Fisher transform) over the others' spread
};

struct ClockOffset {
  /// What is at t by the first clock is at t + seconds by the second one.
  double seconds = 0;
  double peak = 0, second_peak = 0;  ///< correlations, at most 1
  double sigmas = 0;
  bool confident = false;
  bool likely = false;   ///< at two thirds of the sigmas: to be trusted where others confirm it
  double overlap_s = 0;  ///< that both have in common at this offset
  double middle_s = 0;   ///< of the overlap, by the first clock
};

/// The lag at which two signals agree best, to a fraction of a sample. A common event must be in
/// both; what else is in them may differ, and so may levels and gains.
///
/// @param near_s, reach_s  only offsets within reach_s of near_s; reach_s < 0: all
/// @throws UsageError  rates differ, or are not above 0
/// Cost: n log n. Departs from plain normalised correlation: a tenth of the whole energy is added
/// to that of the overlap, so that short overlaps of little energy do not win.
ClockOffset CorrelateSignals(const Signal& a, const Signal& b, const OffsetOptions& options,
                             double near_s = 0, double reach_s = -1);

/// An offset that may change in time: two clocks of which one runs faster.
struct ClockDrift {
  ClockOffset whole;
  bool measured = false;                 ///< the overlap's first and last third each have an offset
  double first_s = 0, last_s = 0;        ///< these offsets
  double first_at_s = 0, last_at_s = 0;  ///< middles of the thirds, by the first clock
  /// Seconds that the second clock gains in one of the first.
  double per_second() const { return measured ? (last_s - first_s) / (last_at_s - first_at_s) : 0; }
};

/// As CorrelateSignals; where it is confident, also of the overlap's first and last third.
ClockDrift CorrelateDrifting(const Signal& a, const Signal& b, const OffsetOptions& options);

/// Values at any ascending times on an even grid, by straight lines between them.
/// @param times_s  as many as values, at least one
Signal Resampled(const std::vector<double>& times_s, const std::vector<double>& values,
                 double per_second);

}  // namespace keypose
