// A value in a project's file, and its place there.
#pragma once

#include <string>

namespace keypose::pipeline {

/// A place in a file, for messages.
struct Where {
  std::string file;
  int line = 0;
  std::string Text() const { return file + ":" + std::to_string(line); }
};

/// One scalar of the file, as text. Its type is checked where it is used.
struct Setting {
  std::string text;
  Where where;
};

}  // namespace keypose::pipeline
