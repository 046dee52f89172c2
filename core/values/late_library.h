// Parts of the product in shared libraries of their own, loaded when they are first needed: what
// these link (for pictures, some 250 libraries) takes longer to load than many a program works.
#pragma once

#include <mutex>

namespace keypose {

/// One of them. Only variables that live as long as the program.
class LateLibrary {
 public:
  /// @param name     of lib/keypose/keypose_NAME.so beside the folder of the program
  /// @param purpose  what it is for, after "to": "read and write pictures"
  LateLibrary(const char* name, const char* purpose);
  LateLibrary(const LateLibrary&) = delete;
  LateLibrary& operator=(const LateLibrary&) = delete;

  /// The address of a C function of its own or of what it links; it stays loaded. Any thread may
  /// call it.
  /// @throws ToolError  it cannot be loaded, or has no such function; names the file
  void* Find(const char* function);

 private:
  friend void LoadLateLibraries();
  void Load();

  const char *name_, *purpose_;
  LateLibrary* next_;
  std::mutex loading_;
  void* handle_ = nullptr;
};

/// Loads all of the program's, before its work is known. One that fails is refused at its use.
void LoadLateLibraries();

}  // namespace keypose
