//! The table of a sweep, a row per sequence and combination: `sequence`, the settings of the grid, the measures that some
//! row has, `seconds`. An absent measure is an empty field.

use std::collections::HashMap;
use std::fmt::Display;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::number::significant;
use crate::settings::{Setting, Settings, Value};
use crate::sweep::grid::{Axis, Grid};
use crate::sweep::table::{Row, SweepTable};
use crate::truth::hota::Hota;
use crate::truth::mask_measures::MaskMeasures;
use crate::truth::measures::{
    COLUMNS, EpisodeMeasures, MeasureColumn, Measures, OBJECTIVE, OF_MASKS, TrackMeasures,
};

/// The first column.
const SEQUENCE: &str = "sequence";
/// The last column.
const SECONDS: &str = "seconds";

/// An error of a file.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be used: {why}", path.display())]
pub struct SweepCsvError {
    /// The file.
    pub path: PathBuf,
    /// The cause, with the line.
    pub why: String,
}

/// The measures that some row has.
pub fn columns(table: &SweepTable) -> Vec<&'static MeasureColumn> {
    let has = |column: &&MeasureColumn| table.rows.iter().any(|row| (column.of)(&row.measures).is_some());
    COLUMNS.iter().filter(has).collect()
}

/// Writes header and rows.
pub fn write(out: &mut impl Write, table: &SweepTable) -> io::Result<()> {
    let columns = columns(table);
    let settings = table.grid.axes().iter().map(|axis| axis.setting.name);
    let measures = columns.iter().map(|column| column.name);
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record([SEQUENCE].into_iter().chain(settings).chain(measures).chain([SECONDS]))?;
    for row in &table.rows {
        let mut fields = vec![table.sequences.get(row.sequence).cloned().unwrap_or_default()];
        fields.extend(table.grid.values(row.combination).iter().map(Value::to_string));
        fields.extend(
            columns.iter().map(|column| (column.of)(&row.measures).map_or_else(String::new, significant)),
        );
        fields.push(significant(row.seconds));
        csv.write_record(fields)?;
    }
    csv.flush()
}

/// Reads a table. Its axes have the values that are in the file, in the order in which they appear; measures that are no
/// column of it are NaN, as the specificity of masks in files of earlier versions. Fails at the first row that is cut or has a value that cannot be.
pub fn read(path: &Path) -> Result<SweepTable, SweepCsvError> {
    let fail = |why: String| {
        // A quoted field may contain line breaks.
        let why = why.split_whitespace().collect::<Vec<_>>().join(" ");
        SweepCsvError { path: path.to_owned(), why }
    };
    let file = File::open(path).map_err(|error| fail(error.to_string()))?;
    parse(csv::Reader::from_reader(file)).map_err(fail)
}

/// A column of a file.
enum Column {
    Sequence,
    Setting(usize),
    Measure(&'static MeasureColumn),
    Seconds,
}

/// Distinct texts in the order of their appearance.
#[derive(Default)]
struct Distinct {
    indices: HashMap<String, usize>,
}

impl Distinct {
    /// The index of a text, and whether it is new.
    fn index(&mut self, text: String) -> (usize, bool) {
        let next = self.indices.len();
        let index = *self.indices.entry(text).or_insert(next);
        (index, index == next)
    }
}

fn parse(mut csv: csv::Reader<File>) -> Result<SweepTable, String> {
    let header = csv.headers().map_err(|error| cause(&error))?.clone();
    let (columns, mut axes) = columns_of(&header)?;
    let mut texts: Vec<Distinct> = axes.iter().map(|_| Distinct::default()).collect();
    let (mut sequences, mut names) = (Vec::new(), Distinct::default());
    let mut rows = Vec::new();
    for record in csv.records() {
        let record = record.map_err(|error| cause(&error))?;
        let line = record.position().map_or(0, csv::Position::line);
        let at_line = |why: String| format!("line {line}: {why}");
        let mut row = Row { sequence: 0, combination: 0, measures: Measures::default(), seconds: 0.0 };
        let mut indices = vec![0; axes.len()];
        let mut values = Vec::new();
        for (column, text) in columns.iter().zip(&record) {
            match column {
                Column::Sequence => {
                    let (index, new) = names.index(text.to_owned());
                    row.sequence = index;
                    if new {
                        sequences.push(text.to_owned());
                    }
                }
                Column::Setting(at) => {
                    let axis: &mut Axis = &mut axes[*at];
                    let mut settings = Settings::default();
                    axis.setting.set_text(&mut settings, text).map_err(|error| at_line(error.to_string()))?;
                    let value = axis.setting.get(&settings);
                    let (index, new) = texts[*at].index(value.to_string());
                    indices[*at] = index;
                    if new {
                        axis.values.push(value);
                    }
                }
                Column::Measure(measure) if text.is_empty() => values.push((measure.name, None)),
                Column::Measure(measure) => {
                    values.push((measure.name, Some(number(measure.name, text).map_err(at_line)?)));
                }
                Column::Seconds => row.seconds = number(SECONDS, text).map_err(at_line)?,
            }
        }
        row.measures = measures(&values).map_err(at_line)?;
        rows.push((row, indices, line));
    }
    if rows.is_empty() {
        return Err("it has no rows".to_owned());
    }
    let grid = Grid::new(axes).map_err(|error| error.to_string())?;
    let mut lines = Vec::with_capacity(rows.len());
    for (row, indices, line) in rows {
        let combination =
            grid.axes().iter().zip(indices).fold(0, |whole, (axis, index)| whole * axis.values.len() + index);
        lines.push((Row { combination, ..row }, line));
    }
    lines.sort_by_key(|(row, _)| (row.sequence, row.combination));
    for pair in lines.windows(2) {
        let [(a, first), (b, second)] = pair else { continue };
        if (a.sequence, a.combination) == (b.sequence, b.combination) {
            return Err(format!("lines {first} and {second} are of the same sequence and settings"));
        }
    }
    Ok(SweepTable { grid, sequences, rows: lines.into_iter().map(|(row, _)| row).collect(), by: &OBJECTIVE })
}

/// The columns of a header, and the axes without values.
fn columns_of(header: &csv::StringRecord) -> Result<(Vec<Column>, Vec<Axis>), String> {
    let mut axes = Vec::new();
    let mut columns = Vec::new();
    for (at, name) in header.iter().enumerate() {
        if header.iter().take(at).any(|other| other == name) {
            return Err(format!("it has two columns `{name}`"));
        }
        columns.push(if name == SEQUENCE {
            Column::Sequence
        } else if name == SECONDS {
            Column::Seconds
        } else if let Some(measure) = COLUMNS.iter().find(|measure| measure.name == name) {
            Column::Measure(measure)
        } else if let Some(setting) = Setting::named(name) {
            axes.push(Axis { setting, values: Vec::new() });
            Column::Setting(axes.len() - 1)
        } else {
            return Err(format!("its column `{name}` is neither a setting nor a measure of a sweep"));
        });
    }
    for needed in [SEQUENCE, SECONDS] {
        if !header.iter().any(|name| name == needed) {
            return Err(format!("it has no column `{needed}`; it is not the sweep.csv of a sweep"));
        }
    }
    Ok((columns, axes))
}

/// The measures of a row from its values by name. Those of one kind of ground truth are all there or all absent.
fn measures(values: &[(&str, Option<f64>)]) -> Result<Measures, String> {
    let value = |name: &str| values.iter().find(|(other, _)| *other == name).and_then(|(_, value)| *value);
    let all = |names: &[&str]| -> Result<Option<Vec<f64>>, String> {
        let found: Vec<f64> = names.iter().filter_map(|name| value(name)).collect();
        match found.len() {
            0 => Ok(None),
            count if count == names.len() => Ok(Some(found)),
            _ => Err(format!("some of {} are absent; they belong together", names.join(", "))),
        }
    };
    let unknown = f64::NAN;
    let with_rates = all(&OF_MASKS[4..])?.is_some();
    let masks = all(if with_rates { &OF_MASKS } else { &OF_MASKS[..4] })?.and_then(|mut values| {
        values.resize(OF_MASKS.len(), unknown);
        let [f, precision, recall, pwc, specificity, fpr, fnr] = values[..] else { return None };
        Some(MaskMeasures { f, precision, recall, pwc, specificity, fpr, fnr })
    });
    let tracks = all(&["mota", "idf1", "hota", "switches"])?.and_then(|values| {
        let [mota, idf1, hota, switches] = values[..] else { return None };
        let hota = Hota { hota, deta: unknown, assa: unknown, loca: unknown };
        Some(TrackMeasures { mota, idf1, hota, switches: switches as usize, identities_kept: None })
    });
    let episodes = all(&["episode_recall", "episode_precision"])?.and_then(|values| {
        let [episode_recall, episode_precision] = values[..] else { return None };
        Some(EpisodeMeasures { episode_recall, episode_precision })
    });
    Ok(Measures { masks, tracks, episodes })
}

fn number(name: &str, text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    let possible = |number: &f64| name != "switches" || (*number >= 0.0 && number.fract() == 0.0);
    let wanted = if name == "switches" { "a count" } else { "a number" };
    number.filter(possible).ok_or_else(|| format!("{name} is `{text}`, not {wanted}"))
}

/// The cause of an error of the reader, in one line.
fn cause(error: &csv::Error) -> String {
    let line = error.position().map_or(0, csv::Position::line);
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("line {line} has {len} values and the header {expected_len}; the file may be cut")
        }
        csv::ErrorKind::Utf8 { .. } => format!("line {line} is not text in UTF-8"),
        csv::ErrorKind::Io(error) => one_line(error),
        _ => one_line(error),
    }
}

fn one_line(error: impl Display) -> String {
    error.to_string().replace('\n', " ")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::fs;

    use super::*;
    use crate::export::tests::written;

    fn table() -> SweepTable {
        let axes = ["rate=weight,density", "alpha=log:0.0005..0.05:9", "bootstrap=0,2.5s"];
        let grid = Grid::new(axes.map(|text| Axis::of_text(text).unwrap()).to_vec()).unwrap();
        let sequences = ["night/a, \"b\"", "day/été\n2", "<script>"].map(str::to_owned).to_vec();
        let mut rows = Vec::new();
        for sequence in 0..sequences.len() {
            for combination in 0..grid.combinations() {
                let share = 1.0 / (3 + sequence + 7 * combination) as f64;
                let masks = MaskMeasures {
                    f: share,
                    precision: 1.0,
                    recall: 0.25,
                    pwc: 100.0 * share,
                    specificity: 1.0 - share,
                    fpr: share,
                    fnr: 0.75,
                };
                let hota = Hota { hota: share.sqrt(), ..Hota::default() };
                let tracks = TrackMeasures {
                    mota: -share,
                    idf1: share,
                    hota,
                    switches: combination,
                    identities_kept: None,
                };
                let measures = Measures {
                    masks: (sequence != 1).then_some(masks),
                    tracks: (sequence != 0).then_some(tracks),
                    episodes: None,
                };
                // A row is missing.
                if (sequence, combination) != (1, 3) {
                    rows.push(Row { sequence, combination, measures, seconds: 12.5 + share });
                }
            }
        }
        SweepTable { grid, sequences, rows, by: &OBJECTIVE }
    }

    fn read_text(text: &[u8]) -> Result<SweepTable, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.csv");
        fs::write(&path, text).unwrap();
        read(&path).map_err(|error| {
            let text = error.to_string();
            assert!(
                text.starts_with(&format!("{} cannot be used: ", path.display())) && !text.contains('\n'),
                "{text}"
            );
            error.why
        })
    }

    #[test]
    fn a_table_reads_back_as_the_same() {
        let table = table();
        let text = written(|out| write(out, &table));
        let header = "sequence,rate,alpha,bootstrap,f,precision,recall,pwc,specificity,fpr,fnr,mota,idf1,hota,\
                      switches,seconds\n";
        assert!(text.starts_with(header), "{text}");
        assert!(text.contains(
            "\"night/a, \"\"b\"\"\",weight,0.0005,0,0.333333333,1,0.25,33.3333333,0.666666667,0.333333333,0.75,,,,,12.8333333\n"
        ));
        let read = read_text(text.as_bytes()).unwrap();
        assert_eq!((&read.sequences, read.rows.len()), (&table.sequences, table.rows.len()));
        for (a, b) in read.grid.axes().iter().zip(table.grid.axes()) {
            assert_eq!((a.setting.name, &a.values), (b.setting.name, &b.values));
        }
        for (a, b) in read.rows.iter().zip(&table.rows) {
            assert_eq!((a.sequence, a.combination), (b.sequence, b.combination));
            for column in &COLUMNS {
                let texts = [a, b].map(|row| (column.of)(&row.measures).map(|value| column.text(value)));
                assert_eq!(texts[0], texts[1], "{}", column.name);
            }
        }
        assert_eq!(written(|out| write(out, &read)), text);
    }

    #[test]
    fn a_table_without_the_rates_of_masks_has_none() {
        let text = "sequence,k,f,precision,recall,pwc,seconds\na,3,0.5,0.5,0.5,2,1\n";
        let table = read_text(text.as_bytes()).unwrap();
        assert_eq!(table.rows[0].measures.masks.unwrap().recall, 0.5);
        let names: Vec<_> = columns(&table).iter().map(|column| column.name).collect();
        assert_eq!(names, ["f", "precision", "recall", "pwc"]);
        assert_eq!(written(|out| write(out, &table)), text);
    }

    #[test]
    fn the_order_of_rows_and_columns_is_free() {
        let text = "\u{feff}seconds,k,sequence,hota,mota,idf1,switches\n1,4,b,0.5,0.5,0.5,2\n1,3,b,0.25,0.5,0.5,0\n1,4,a,,,,\n";
        let table = read_text(text.as_bytes()).unwrap();
        assert_eq!((table.grid.name(0).as_str(), table.grid.combinations()), ("k=4", 2));
        assert_eq!(table.sequences, ["b", "a"]);
        assert_eq!(
            table.rows.iter().map(|row| (row.sequence, row.combination)).collect::<Vec<_>>(),
            [(0, 0), (0, 1), (1, 0)]
        );
        assert_eq!(table.rows[2].measures, Measures::default());
        let alone = read_text(b"sequence,seconds\na,1\n").unwrap();
        assert_eq!((alone.grid.combinations(), alone.rows.len()), (1, 1));
    }

    #[test]
    fn what_cannot_be_is_told_with_its_line() {
        for (text, why) in [
            ("", "no column `sequence`"),
            ("sequence,k,seconds\n", "no rows"),
            ("frame,id,x\n1,2,3\n", "column `frame` is neither"),
            ("sequence,kk,seconds\na,3,1\n", "column `kk` is neither"),
            ("sequence,\"k\nk\",seconds\na,3,1\n", "column `k k` is neither"),
            ("sequence,k,k,seconds\na,3,3,1\n", "two columns `k`"),
            ("sequence,k\na,3\n", "no column `seconds`"),
            ("sequence,k,seconds\na,3,1\na,99,1\n", "line 3: the setting `k` cannot be `99`"),
            ("sequence,k,seconds\na,3,1\na,4\n", "line 3 has 2 values and the header 3"),
            ("sequence,k,seconds\na,3,nan\n", "line 2: seconds is `nan`"),
            ("sequence,k,seconds\na,3,1\nb,3,1\na,3,1\n", "lines 2 and 4 are of the same"),
            ("sequence,f,precision,recall,pwc,seconds\na,NaN,1,1,1,1\n", "line 2: f is `NaN`"),
            (
                "sequence,f,precision,recall,pwc,seconds\na,1,1,,1,1\n",
                "line 2: some of f, precision, recall, pwc",
            ),
            ("sequence,f,seconds\na,1,1\n", "line 2: some of f"),
            ("sequence,fpr,seconds\na,1,1\n", "line 2: some of specificity, fpr, fnr"),
            ("sequence,fpr,fnr,specificity,seconds\na,1,1,1,1\n", "line 2: some of f, precision"),
            ("sequence,mota,idf1,hota,switches,seconds\na,1,1,1,-1,1\n", "switches is `-1`, not a count"),
        ] {
            let error = read_text(text.as_bytes()).unwrap_err();
            assert!(error.contains(why), "{text}: {error}");
        }
        assert!(read_text(b"sequence,seconds\n\xff\xfe,1\n").unwrap_err().contains("line 2 is not text"));
        assert!(read(Path::new("/nowhere/sweep.csv")).unwrap_err().to_string().contains("No such file"));
        // A file that is cut anywhere is read in part or told.
        let whole = written(|out| write(out, &table()));
        for end in (0..whole.len()).step_by(7) {
            let _ = read_text(&whole.as_bytes()[..end]);
        }
    }
}
