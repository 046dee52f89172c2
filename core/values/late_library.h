// Parts of the product in shared libraries of their own, loaded when they are first needed: what
// these link (for pictures, some 250 libraries) takes longer to load than many a program works.
#pragma once

#include <mutex>

namespace keypose {

/// One of them. Only variables that live as long as the program.
class LateLibrary {
 public:
  /// @param name     of lib/keypose/keypose_NAME.so beside the folder of the program
  /// @param entry    the C function in it
  /// @param purpose  what it is for, after "to": "read and write pictures"
  LateLibrary(const char* name, const char* entry, const char* purpose);
  LateLibrary(const LateLibrary&) = delete;
  LateLibrary& operator=(const LateLibrary&) = delete;

  /// The address of the C function; the library stays loaded. Any thread may call it.
  /// @throws ToolError  it cannot be loaded; names the file
  void* Entry();

 private:
  friend void LoadLateLibraries();

  const char *name_, *entry_, *purpose_;
  LateLibrary* next_;
  std::mutex loading_;
  void* address_ = nullptr;
};

/// Loads all of the program's, before its work is known. One that fails is refused at its use.
void LoadLateLibraries();

}  // namespace keypose
