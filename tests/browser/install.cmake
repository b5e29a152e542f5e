# cmake -P install.cmake: the packages of these tests, as package-lock.json has them, if they are not there.
cmake_minimum_required(VERSION 3.25)
set(here ${CMAKE_CURRENT_LIST_DIR})
set(stamp ${here}/node_modules/.stamp)
file(SHA256 ${here}/package-lock.json digest)
if(EXISTS ${stamp})
  file(READ ${stamp} installed)
endif()
if(NOT "${installed}" STREQUAL "${digest}")
  execute_process(COMMAND npm ci --ignore-scripts --no-audit --no-fund --no-update-notifier --loglevel=error
    WORKING_DIRECTORY ${here} COMMAND_ERROR_IS_FATAL ANY)
  file(WRITE ${stamp} ${digest})
endif()
