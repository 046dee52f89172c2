# cmake -DSCRIPT=bundle.js -DOUTPUT=player_script.cpp -P embed_script.cmake: the bundle as a string of the program.
file(READ "${SCRIPT}" text)
string(FIND "${text}" ")keypose_js" ends)
if(NOT ends EQUAL -1)
  message(FATAL_ERROR "${SCRIPT} holds the mark that would end its string; choose another in embed_script.cmake")
endif()
file(WRITE "${OUTPUT}" "#include \"report/player_data.h\"\n
namespace keypose::report {
const char* PlayerScript() {
  static const char kScript[] = R\"keypose_js(${text})keypose_js\";
  return kScript;
}
}  // namespace keypose::report\n")
