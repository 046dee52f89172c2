// A recording session on disk: a journal that no crash can spoil, and the curves made from it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "armature/description/armature.h"
#include "armature/recording/joint_curves.h"

namespace keypose::armature {

struct RecordingOptions {
  double fps = 24;
  int step = 1;  ///< frames of the film that a recorded frame is held
};

/// Frames are recorded one after another; one can go back and record them anew. Each change is on
/// the disk before its function returns.
///
///     FOLDER/journal.jsonl    what happened, a line each
///     FOLDER/curves.json, curves.csv, curves.bvh, flipbook.json, flipbook.svg
class RecordingSession {
 public:
  /// Begins a session, or takes up the one that is there.
  /// @param armature  must outlive this
  /// @throws DiskError    the folder cannot be made or written
  /// @throws LockedError  another program records into it
  /// @throws InputError   it was begun with another armature, frame rate or step, or its journal is
  /// damaged before its last line (names the line)
  RecordingSession(const Armature& armature, const std::filesystem::path& folder,
                   const RecordingOptions& options);
  RecordingSession(const RecordingSession&) = delete;
  RecordingSession& operator=(const RecordingSession&) = delete;

  int frame_count() const { return static_cast<int>(frames_.size()); }
  /// The frame that is recorded next; frame_count() is a new one.
  int at() const { return at_; }
  const std::vector<std::vector<double>>& frames() const { return frames_; }
  /// Whether the last line of the journal was cut off when it was taken up: what it held is lost.
  bool was_cut_off() const { return was_cut_off_; }

  /// Writes the frame that it is at, and goes to the next.
  /// @param values  of all joints, as ForwardKinematics takes them
  void Record(const std::vector<double>& values);
  /// @param frame  is brought into [0, frame_count()]
  void GoTo(int frame);
  /// Forgets the frame that it is at and all after it.
  void CutHere();

  JointCurves Curves() const;
  /// Writes curves and flipbook anew; Record and CutHere do so by themselves.
  void WriteCurves() const;

 private:
  /// Closes its file also when the session could not be opened.
  struct OpenFile {
    ~OpenFile();
    int fd = -1;
  };
  void Lock();
  void TakeUp(const std::string& text);
  void Apply(const std::string& line, int number);
  void Append(const std::string& line);

  const Armature& armature_;
  std::filesystem::path folder_;
  RecordingOptions options_;
  std::vector<std::vector<double>> frames_;
  int at_ = 0;
  bool was_cut_off_ = false;
  OpenFile lock_, journal_;
};

}  // namespace keypose::armature
