//! The words of messages: what the system says, and the way out.

use std::io;

use super::BankFault;

/// The text on one line: control characters and line breaks are escaped.
pub(crate) fn one_line(text: &impl ToString) -> String {
    text.to_string()
        .chars()
        .flat_map(|c| {
            let escaped = c.is_control() || matches!(c, '\u{2028}' | '\u{2029}');
            let (plain, escape) = if escaped {
                (None, Some(c.escape_default()))
            } else {
                (Some(c), None)
            };
            plain.into_iter().chain(escape.into_iter().flatten())
        })
        .collect()
}

/// What the system says, in words.
pub(crate) fn io_fact(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "no such file or folder".to_owned(),
        io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        io::ErrorKind::NotADirectory => "a part of the path is a file, not a folder".to_owned(),
        io::ErrorKind::IsADirectory => "it is a folder".to_owned(),
        io::ErrorKind::StorageFull => "no space left on the device".to_owned(),
        io::ErrorKind::QuotaExceeded => "the disk quota is used up".to_owned(),
        io::ErrorKind::ReadOnlyFilesystem => "the file system is read-only".to_owned(),
        io::ErrorKind::InvalidFilename => "the file name is too long or not valid".to_owned(),
        _ => one_line(error),
    }
}

/// What to do about it.
pub(crate) fn io_way_out(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::PermissionDenied => "check the permissions of the file and its folder",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "free some space or choose another disk"
        }
        io::ErrorKind::ReadOnlyFilesystem => "choose a folder on another disk",
        io::ErrorKind::InvalidFilename => "choose a shorter name",
        _ => "check the path",
    }
}

/// What to do about a bank.
pub(crate) fn bank_way_out(fault: &BankFault) -> &'static str {
    match fault {
        BankFault::NotABank => "check the path",
        BankFault::NewerVersion { .. } => "read it with the program that wrote it, or a later one",
        BankFault::NoRecord { .. } => "ask for one that it has",
        BankFault::TooLong { .. } => "use smaller frames",
        _ => "copy it again, or make it again from its recipe and seed",
    }
}
