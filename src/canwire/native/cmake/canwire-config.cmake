# find_package(canwire) gives canwire::vciapi, vcinpl, vcinpl2, candrv and acan, and canwire::canwire below them.
get_filename_component(_canwire_home "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)
foreach(_canwire_name canwire vciapi vcinpl vcinpl2 candrv acan)
  if(NOT TARGET canwire::${_canwire_name})
    add_library(canwire::${_canwire_name} SHARED IMPORTED)
    set_target_properties(canwire::${_canwire_name} PROPERTIES
      IMPORTED_LOCATION "${_canwire_home}/lib/lib${_canwire_name}.so"
      INTERFACE_INCLUDE_DIRECTORIES "${_canwire_home}/include")
  endif()
endforeach()
set_target_properties(canwire::vciapi canwire::candrv canwire::acan PROPERTIES INTERFACE_LINK_LIBRARIES canwire::canwire)
set_target_properties(canwire::vcinpl PROPERTIES INTERFACE_LINK_LIBRARIES "canwire::vciapi;canwire::canwire")
set_target_properties(canwire::vcinpl2 PROPERTIES INTERFACE_LINK_LIBRARIES "canwire::vciapi;canwire::canwire")
set(canwire_FOUND TRUE)
