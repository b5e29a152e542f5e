# cmake -P web/build.cmake
# Builds the page into build/web, once for all presets: packages as package-lock.json has them, Vite, then
# the C++ table of its files. What is there already for the same sources is left alone.
cmake_minimum_required(VERSION 3.25)
set(web ${CMAKE_CURRENT_LIST_DIR})
cmake_path(SET out NORMALIZE "${web}/../build/web")

# Presets that build at the same time take turns.
file(MAKE_DIRECTORY ${out})
file(LOCK ${out}/lock TIMEOUT 600)

# The sources' names and contents.
function(digest variable)
  set(all "")
  foreach(file IN LISTS ARGN)
    file(SHA256 ${file} hash)
    cmake_path(RELATIVE_PATH file BASE_DIRECTORY ${web})
    string(APPEND all "${file} ${hash}\n")
  endforeach()
  string(SHA256 all "${all}")
  set(${variable} ${all} PARENT_SCOPE)
endfunction()

# True if FILE says DIGEST.
function(is_stamped variable file digest)
  set(stamp "")
  if(EXISTS ${file})
    file(READ ${file} stamp)
  endif()
  string(COMPARE EQUAL "${stamp}" "${digest}" same)
  set(${variable} ${same} PARENT_SCOPE)
endfunction()

function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${web} RESULT_VARIABLE result
    OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(NOTICE "${said}")
    message(FATAL_ERROR "The page could not be built: \"${command}\" in web/ failed, see above. "
      "It needs node 18 or newer and, the first time, npm's registry. The service is built without its "
      "page with -DISOCAUSTIC_PAGE=OFF (ISOCAUSTIC_PAGE=OFF ./dev run).")
  endif()
endfunction()

file(GLOB_RECURSE sources ${web}/src/* ${web}/public/*)
list(APPEND sources ${web}/index.html ${web}/docs.html ${web}/package.json ${web}/package-lock.json
  ${web}/tsconfig.json ${web}/vite.config.ts ${web}/embed.mjs ${web}/build.cmake)
digest(page_digest ${sources})
is_stamped(done ${out}/page.stamp ${page_digest})
if(done AND EXISTS ${out}/page_data.h)
  return()
endif()

# Nothing of a package is run when it is installed: none needs it, and some would call home.
digest(packages_digest ${web}/package.json ${web}/package-lock.json)
is_stamped(installed ${web}/node_modules/.stamp ${packages_digest})
if(NOT installed)
  message(STATUS "The page: npm ci")
  run(npm ci --ignore-scripts --no-audit --no-fund --no-update-notifier --loglevel=error)
  file(WRITE ${web}/node_modules/.stamp ${packages_digest})
endif()
message(STATUS "The page: type check, vite build")
run(node node_modules/typescript/bin/tsc --noEmit)
run(node node_modules/vite/bin/vite.js build --logLevel warn)
run(node embed.mjs ${out}/dist ${out}/page_data.h)
file(WRITE ${out}/page.stamp ${page_digest})
