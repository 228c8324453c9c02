//! All tests of recipes, breaking and showing as one program, which is built and run sooner than one for each file.

mod alpha;
mod dashboard;
mod deposits;
mod faults;
mod import_hostile;
mod import_on_pane;
mod import_svg;
mod live;
mod presets;
mod recipe;
mod recipe_models;
mod recipe_optics;
mod resolution;
mod severity;
