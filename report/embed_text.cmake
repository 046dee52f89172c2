# cmake -DTEXT=bundle.js -DHEADER=report/player/player_data.h -DFUNCTION=PlayerScript -DOUTPUT=player_script.cpp
#       -P embed_text.cmake: a file as a string of the program.
file(READ "${TEXT}" text)
string(FIND "${text}" ")keypose_text" ends)
if(NOT ends EQUAL -1)
  message(FATAL_ERROR "${TEXT} holds the mark that would end its string; choose another in embed_text.cmake")
endif()
file(WRITE "${OUTPUT}" "#include \"${HEADER}\"\n
namespace keypose::report {
const char* ${FUNCTION}() {
  static const char kText[] = R\"keypose_text(${text})keypose_text\";
  return kText;
}
}  // namespace keypose::report\n")
