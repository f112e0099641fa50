//! Archives, shards, and numbers as they are written and drawn.

use hertzchain::{
    internals::{available, bytes, lacking},
    output::NpzWriter,
    sweep::Shard,
};
use hertzchain_report::{
    internals::npy_head,
    number::{format_parameter, of_pi},
};
use std::io::Cursor;

#[test]
fn words_are_letters_of_four_bytes_filled_up_with_zeros() {
    // Truth: NumPy's type `<U2`: UCS-4, little-endian.
    let mut bytes = Cursor::new(Vec::new());
    let mut archive = NpzWriter::new(&mut bytes, None).unwrap();
    archive.words("names", &["αb".to_owned(), "c".to_owned()]).unwrap();
    archive.finish().unwrap();
    let letters = ['α', 'b', 'c', '\0'].map(|letter| u32::from(letter).to_le_bytes()).concat();
    let wanted = [npy_head("<U2", &[2]), letters].concat();
    assert!(bytes.into_inner().windows(wanted.len()).any(|part| part == wanted));
}

#[test]
fn an_array_begins_as_numpy_says() {
    // Truth: NumPy's description of the format: magic, version, length of the text, a
    // dictionary, blanks up to a multiple of 64.
    for (shape, text) in [(&[401, 99][..], "(401, 99, )"), (&[7], "(7, )"), (&[], "()"), (&[u64::MAX; 9], "(")] {
        let head = npy_head("<f8", shape);
        assert_eq!(&head[..8], b"\x93NUMPY\x01\x00");
        assert_eq!((head.len() % 64, usize::from(head[8]) + 256 * usize::from(head[9]) + 10), (0, head.len()));
        let dictionary = std::str::from_utf8(&head[10..]).unwrap();
        assert!(dictionary.starts_with(&format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {text}")));
        assert!(dictionary.trim_end_matches([' ', '\n']).ends_with(", }") && dictionary.ends_with('\n'));
    }
}

#[test]
fn every_point_is_in_one_shard_and_every_shard_has_its_share_of_each_column() {
    for n in 1..=12 {
        let shards: Vec<Shard> = (1..=n).map(|k| format!("{k}/{n}").parse().unwrap()).collect();
        let share = |shard: Shard, points: usize| (0..points).filter(|&k| shard.has(k)).count();
        for points in n..60 {
            assert!((0..points).all(|k| shards.iter().filter(|shard| shard.has(k)).count() == 1));
            let shares = shards.iter().map(|&shard| share(shard, points));
            assert!(shares.clone().max() <= shares.min().map(|least| least + 1), "{n} {points}");
        }
        // A grid of n by n: one point of every row and column each.
        let columns = |shard: Shard| (0..n * n).filter(move |&k| shard.has(k)).map(move |k| k % n);
        for &shard in &shards {
            let mut columns: Vec<usize> = columns(shard).collect();
            columns.sort_unstable();
            assert!(columns.into_iter().eq(0..n));
        }
    }
}

#[test]
fn bytes_are_said_in_the_next_unit() {
    assert_eq!([999, 1000, 1_234_567, 96_000_000_000].map(bytes), ["999 B", "1.000 kB", "1.235 MB", "96.000 GB"]);
}

#[cfg(target_os = "linux")]
#[test]
fn the_memory_that_is_available_is_less_than_that_of_the_machine() {
    let field = |name: &str| -> u64 {
        let all = std::fs::read_to_string("/proc/meminfo").unwrap();
        all.lines().find_map(|line| line.strip_prefix(name)?.split_whitespace().next()?.parse().ok()).unwrap()
    };
    let (free, all) = (available().unwrap(), field("MemTotal:"));
    assert!(free > 1 << 20 && free <= 1024 * (all + field("SwapFree:")));
    assert!(lacking(1 << 10).is_none() && lacking(u64::MAX).is_some_and(|words| words.contains(" are available")));
}

#[test]
fn angles_are_fractions_of_pi() {
    use std::f64::consts::PI;
    let cases = [(0.2 * PI, "π/5"), (0.8 * PI, "4π/5"), (-PI, "-π"), (2.0 * PI, "2π"), (1.0, "0.3183 π")];
    for (angle, text) in cases {
        assert_eq!(of_pi(angle), text);
    }
}

#[test]
fn parameters_are_written_as_people_write_them() {
    let cases = [
        (1.5, "1.5"),
        (1.0 / 3.0, "1/3"),
        (-5.0 / 6.0, "-5/6"),
        (1000.0, "1000"),
        (f64::INFINITY, "∞"),
        (0.333_333_3, "0.3333"),
        (std::f64::consts::PI, "3.142"),
        (1.234_567_89e-7, "1.235e-7"),
    ];
    for (x, text) in cases {
        assert_eq!(format_parameter(x), text);
    }
}
