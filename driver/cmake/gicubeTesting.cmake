# gicube_add_test(NAME name
#                 [SOURCES a.cpp ...]       # a program of its own, linked with gicube::gicube ...
#                 [LIBRARIES target ...]    # ... and these, as GTest::gtest_main
#                 [COMMAND program arg ...] # or a program that there is: a target or a file
#                 [BUS pci33 agp2x ...]     # host buses; several make a test of each, called name.bus
#                 [FIDELITY level]          # functional or cycle
#                 [CONFIG file]             # a board configuration
#                 [SET field=value ...]     # single fields of it, as asic.processors=8
#                 [FAULTS file]             # a fault plan
#                 [SEED number]             # of the test's own random choices
#                 [BOARD uri]               # another board than one of its own; then without BUS .. FAULTS
#                 [TIMEOUT seconds])        # wall clock, 300 if not given
#
# Adds a CTest test that opens its board by gicube::test::BoardSetup (gicube/testing.h): all of the above comes to it in
# the environment, as GICUBE_TEST_BUS and so on, and GICUBE_BOARD names the board's program. The same program started by
# hand, without them, has the board's defaults. The executable is called name too.
function(gicube_add_test)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "NAME;FIDELITY;CONFIG;FAULTS;SEED;BOARD;TIMEOUT"
    "SOURCES;LIBRARIES;COMMAND;BUS;SET")
  if(arg_UNPARSED_ARGUMENTS OR arg_KEYWORDS_MISSING_VALUES)
    message(FATAL_ERROR "gicube_add_test: not understood: ${arg_UNPARSED_ARGUMENTS} ${arg_KEYWORDS_MISSING_VALUES}")
  endif()
  if(NOT arg_NAME)
    message(FATAL_ERROR "gicube_add_test: NAME is missing")
  endif()
  if((arg_SOURCES AND arg_COMMAND) OR NOT (arg_SOURCES OR arg_COMMAND))
    message(FATAL_ERROR "gicube_add_test(${arg_NAME}): expected either SOURCES or COMMAND")
  endif()
  if(arg_BOARD AND (arg_BUS OR arg_FIDELITY OR arg_CONFIG OR arg_SET OR arg_FAULTS))
    message(FATAL_ERROR "gicube_add_test(${arg_NAME}): BOARD is a board that there is: it takes no BUS, FIDELITY, "
      "CONFIG, SET or FAULTS")
  endif()
  foreach(bus ${arg_BUS})
    if(NOT bus MATCHES "^(pci33|agp1x|agp2x|agp4x)$")
      message(FATAL_ERROR "gicube_add_test(${arg_NAME}): BUS: expected pci33, agp1x, agp2x or agp4x, got ${bus}")
    endif()
  endforeach()
  if(DEFINED arg_FIDELITY AND NOT arg_FIDELITY MATCHES "^(functional|cycle)$")
    message(FATAL_ERROR "gicube_add_test(${arg_NAME}): FIDELITY: expected functional or cycle, got ${arg_FIDELITY}")
  endif()
  foreach(field CONFIG FAULTS)
    if(arg_${field})
      get_filename_component(arg_${field} "${arg_${field}}" ABSOLUTE)
      if(NOT EXISTS "${arg_${field}}" OR IS_DIRECTORY "${arg_${field}}")
        message(FATAL_ERROR "gicube_add_test(${arg_NAME}): ${field}: expected a file, got ${arg_${field}}")
      endif()
    endif()
  endforeach()

  if(arg_SOURCES)
    add_executable(${arg_NAME} ${arg_SOURCES})
    target_link_libraries(${arg_NAME} PRIVATE gicube::gicube ${arg_LIBRARIES})
    set(arg_COMMAND ${arg_NAME})
  endif()
  # A driver that is linked into the tests finds the program of its own build or installation.
  set(environment "GICUBE_BOARD=$<TARGET_FILE:gicube::board>")
  foreach(field FIDELITY SEED BOARD)
    if(DEFINED arg_${field})
      list(APPEND environment "GICUBE_TEST_${field}=${arg_${field}}")
    endif()
  endforeach()
  foreach(field CONFIG FAULTS)
    if(arg_${field})
      list(APPEND environment "GICUBE_TEST_${field}=${arg_${field}}")
    endif()
  endforeach()
  if(arg_SET)
    string(JOIN " " fields ${arg_SET})
    list(APPEND environment "GICUBE_TEST_SET=${fields}")
  endif()
  if(NOT DEFINED arg_TIMEOUT)
    set(arg_TIMEOUT 300)
  endif()

  list(LENGTH arg_BUS buses)
  if(buses EQUAL 0)
    add_test(NAME ${arg_NAME} COMMAND ${arg_COMMAND})
    set_tests_properties(${arg_NAME} PROPERTIES ENVIRONMENT "${environment}" TIMEOUT ${arg_TIMEOUT})
  endif()
  foreach(bus ${arg_BUS})
    set(test ${arg_NAME})
    if(buses GREATER 1)
      set(test ${arg_NAME}.${bus})
    endif()
    add_test(NAME ${test} COMMAND ${arg_COMMAND})
    set_tests_properties(${test} PROPERTIES
      ENVIRONMENT "${environment};GICUBE_TEST_BUS=${bus}" TIMEOUT ${arg_TIMEOUT})
  endforeach()
endfunction()
