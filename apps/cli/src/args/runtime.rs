//! Flags for what runs a detector, and where the library of ONNX Runtime is looked for.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use clap::{Args as ClapArgs, ValueEnum};
use starbreak_detect::{Backend, Device};

use crate::failure::Failure;
use crate::screen::Screen;

/// The variable that names the library, as other programs with ONNX Runtime read it.
const LIBRARY_VARIABLE: &str = "ORT_DYLIB_PATH";

/// The library's name where the system looks for it: on Linux alone, for others look into the present folder, too.
const SYSTEM_LIBRARY: Option<&str> = if cfg!(target_os = "linux") {
    Some("libonnxruntime.so")
} else {
    None
};

/// Python that prints the library in the package onnxruntime.
const OF_PACKAGE: &str = include_str!("library_of_onnxruntime.py");

/// What runs a detector.
#[derive(Debug, ClapArgs)]
pub(crate) struct RuntimeArgs {
    /// What runs the detector: `rten` is part of this program; `onnxruntime` must be installed (`pip install
    /// onnxruntime`), is faster and knows all operators; `auto` takes ONNX Runtime if it is found. Both agree but for
    /// the last digits [default: rten, or onnxruntime with --onnxruntime or --cuda]
    #[arg(long, value_enum, value_name = "NAME")]
    pub(crate) runtime: Option<RuntimeWord>,
    /// Library of ONNX Runtime [default: that in the variable ORT_DYLIB_PATH, else that of the Python package
    /// onnxruntime, else the system's]
    #[arg(long, value_name = "PATH")]
    pub(crate) onnxruntime: Option<PathBuf>,
    /// Run the detector on an NVIDIA GPU, by ONNX Runtime (`pip install onnxruntime-gpu`)
    #[arg(long)]
    pub(crate) cuda: bool,
}

/// What runs a detector, as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RuntimeWord {
    /// In Rust, part of this program
    Rten,
    /// The installed library
    Onnxruntime,
    /// ONNX Runtime if it is found, else rten
    Auto,
}

impl RuntimeArgs {
    /// What runs the detector, with its library loaded.
    pub(crate) fn backend(&self, screen: &Screen) -> Result<Backend, Failure> {
        let wants_library = self.onnxruntime.is_some() || self.cuda;
        let word = self.runtime.unwrap_or(match wants_library {
            true => RuntimeWord::Onnxruntime,
            false => RuntimeWord::Rten,
        });
        if word == RuntimeWord::Rten {
            if wants_library {
                return Err(Failure::wrong_input(
                    "--onnxruntime and --cuda are for ONNX Runtime, and --runtime rten asks for rten; leave one of \
                     them out",
                ));
            }
            return Ok(Backend::PureRust);
        }
        match (self.library(), word) {
            (Ok(backend), _) => Ok(backend),
            (Err(why), RuntimeWord::Auto) if !self.cuda => {
                screen.note(&format!("warning: {why}; rten runs the detectors"));
                Ok(Backend::PureRust)
            }
            (Err(why), _) => Err(Failure::wrong_input(format!(
                "{why}; install it (pip install onnxruntime, or onnxruntime-gpu for --cuda), name its library with \
                 --onnxruntime PATH, or use --runtime rten"
            ))),
        }
    }

    /// ONNX Runtime by the first library that can be loaded, or why there is none.
    fn library(&self) -> Result<Backend, String> {
        let device = if self.cuda { Device::Cuda } else { Device::Cpu };
        let mut reasons = Vec::new();
        for library in self.candidates() {
            let backend = Backend::OnnxRuntime { library, device };
            match backend.name() {
                Ok(_) => return Ok(backend),
                Err(error) => reasons.push(error.to_string()),
            }
        }
        if reasons.is_empty() {
            reasons.push("ONNX Runtime is not found".to_owned());
        }
        Err(reasons.join("; "))
    }

    /// Libraries to try. One that is named is the only one.
    fn candidates(&self) -> Vec<PathBuf> {
        let named = self.onnxruntime.clone();
        let in_variable = std::env::var_os(LIBRARY_VARIABLE).filter(|path| !path.is_empty());
        if let Some(library) = named.or(in_variable.map(PathBuf::from)) {
            // A relative path is seen from here, not from where the program lies.
            return vec![std::path::absolute(&library).unwrap_or(library)];
        }
        let of_python = of_python("python3").or_else(|| of_python("python"));
        let of_system = SYSTEM_LIBRARY.map(PathBuf::from);
        of_python.into_iter().chain(of_system).collect()
    }
}

/// The library in the package onnxruntime of a Python.
fn of_python(program: &str) -> Option<PathBuf> {
    let mut command = Command::new(program);
    let command = command
        .args(["-X", "utf8", "-c", OF_PACKAGE])
        .stdin(Stdio::null());
    let said = command.output().ok().filter(|said| said.status.success())?;
    let library = String::from_utf8(said.stdout).ok()?;
    let library = library.lines().last().filter(|path| !path.is_empty());
    library.map(PathBuf::from)
}
