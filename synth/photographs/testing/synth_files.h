// A small world that was photographed into files.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>

#include "core/testing/folder.h"
#include "synth/commands/photos_command.h"
#include "synth/photographs/damaged_photographs.h"

namespace keypose::synth {

namespace fs = std::filesystem;

// Six small photographs per pose of two poses, rendered once for all tests of this file.
class SynthFiles : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    own_ = std::make_unique<TestingFolder>();
    command_.output = folder_ = own_->path();
    command_.world.spacing_m = 0.006;
    command_.photographer.views = 6;
    command_.photographer.width = 200, command_.photographer.height = 150;
    command_.clean_plate = true;
    written_ = RunPhotos(command_, nullptr);
  }
  static void TearDownTestSuite() { own_.reset(); }
  fs::path Spoilt(DamageKind kind, const std::string& name) const {
    const fs::path to = folder_ / ("spoilt_" + std::to_string(static_cast<int>(kind)));
    DamagePhotos(folder_ / "photos/rest", to, kind, {name});
    return to / name;
  }
  static inline std::unique_ptr<TestingFolder> own_;
  static inline fs::path folder_;
  static inline PhotosCommand command_;
  static inline int written_ = 0;
};

}  // namespace keypose::synth
