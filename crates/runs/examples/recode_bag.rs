//! Decode and rewrite alone: the floor that `starbreak bag` is measured against.
//!
//! `recode_bag N_THREADS IN OUT` reads each message of a bag, decodes the compressed images of its cameras, encodes them
//! in their format with the quality of the default recipe, and writes all messages again, with the codecs, threads and
//! compression of `bag`, to the disk as it does. One batch is in memory.
#![expect(clippy::print_stdout, reason = "an example shows its result")]

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Read as _};
use std::time::Instant;

use mcap::records::{MessageHeader, Record};
use mcap::sans_io::{LinearReadEvent, LinearReader};
use mcap::{Compression, WriteOptions, Writer};
use rayon::prelude::*;
use starbreak_dataset::{ImageLimits, JpegQuality};
use starbreak_runs::bag::{CameraKind, CameraMessage};
use starbreak_runs::with_threads;

/// That of the command.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// A message, and what it is if it is one of a camera.
type Message = (MessageHeader, Vec<u8>, Option<CameraKind>);

fn main() -> Result<(), Failure> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [n_threads, from, to] = args.as_slice() else {
        return Err("expected N_THREADS IN OUT".into());
    };
    let started = Instant::now();
    let n_messages = with_threads(n_threads.parse()?, || recode(from, to))??;
    println!(
        "{n_messages} messages in {:.3} s",
        started.elapsed().as_secs_f64()
    );
    Ok(())
}

fn recode(from: &str, to: &str) -> Result<u64, Failure> {
    let n_batch = (2 * rayon::current_num_threads()).clamp(2, 16);
    let mut file = File::open(from)?;
    let mut reader = LinearReader::new();
    let mut options = WriteOptions::new().profile("ros2").compression_threads(0);
    // That of the bags that are measured, by name.
    options = options.compression(match from {
        name if name.contains("zstd") => Some(Compression::Zstd),
        name if name.contains("lz4") => Some(Compression::Lz4),
        _ => None,
    });
    let mut writer = options.create(BufWriter::with_capacity(1 << 20, File::create(to)?))?;
    let mut kinds = BTreeMap::new();
    let mut schemas = BTreeMap::new();
    let mut batch: Vec<Message> = Vec::new();
    let mut n_messages = 0;
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(n_bytes) => {
                let n_bytes = n_bytes.max(1 << 20);
                let read = file.read(reader.insert(n_bytes))?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { opcode, data } => match mcap::parse_record(opcode, data)? {
                Record::Schema { header, data } => {
                    writer.add_schema_with_id(header.id, &header.name, &header.encoding, &data)?;
                    schemas.insert(header.id, header.name);
                }
                Record::Channel(it) => {
                    let kind = match schemas.get(&it.schema_id).map(String::as_str) {
                        Some("sensor_msgs/msg/Image") => Some(CameraKind::Raw),
                        Some("sensor_msgs/msg/CompressedImage") => Some(CameraKind::Compressed),
                        _ => None,
                    };
                    kinds.insert(it.id, kind);
                    let encoding = &it.message_encoding;
                    writer.add_channel_with_id(
                        it.id,
                        it.schema_id,
                        &it.topic,
                        encoding,
                        &it.metadata,
                    )?;
                }
                Record::Message { header, data } => {
                    n_messages += 1;
                    let kind = kinds.get(&header.channel_id).copied().flatten();
                    batch.push((header, data.into_owned(), kind));
                    if batch.len() >= n_batch {
                        write(&mut writer, std::mem::take(&mut batch))?;
                    }
                }
                _ => {}
            },
        }
    }
    write(&mut writer, batch)?;
    writer.finish()?;
    // On the disk, as `bag` leaves it.
    writer.into_inner().into_inner()?.sync_all()?;
    Ok(n_messages)
}

fn write(writer: &mut Writer<BufWriter<File>>, batch: Vec<Message>) -> Result<(), Failure> {
    let again: Vec<(MessageHeader, Vec<u8>)> = batch
        .into_par_iter()
        .map(|(header, data, kind)| {
            let Some(kind) = kind else {
                return Ok((header, data));
            };
            let message = CameraMessage::read(kind, &data)?;
            Ok(match message.file(&data, &ImageLimits::default())? {
                Some(file) => {
                    let data = message.with_file(&data, &file, JpegQuality::new(95)?)?;
                    (header, data)
                }
                // Pixels of a raw image are as they are in memory.
                None => (header, data),
            })
        })
        .collect::<Result<_, Failure>>()?;
    for (header, data) in again {
        writer.write_to_known_channel(&header, &data)?;
    }
    Ok(())
}
