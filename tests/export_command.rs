//! The `export` command as a user runs it: files, exit codes, determinism.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.0.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

fn export(input: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lattice-brep")).arg("export").arg(input).args(more).output().unwrap()
}

fn stderr(out: &Output) -> String {
    String::from_utf8(out.stderr.clone()).unwrap()
}

/// A corner of three struts, one of them bent on.
const CORNER: &str = r#"{"units":"mm","nodes":[[0,0,0],[10,0,0],[0,10,0],[0,0,10],[10,8,3]],
"struts":[{"a":0,"b":1,"ra":1,"rb":1},{"a":0,"b":2,"ra":1,"rb":1},{"a":0,"b":3,"ra":1,"rb":1},{"a":1,"b":4,"ra":1,"rb":1}]}"#;

#[test]
fn same_bytes_at_any_thread_count_and_in_every_run() {
    let folder = Folder::new();
    let graph = folder.write("corner.json", CORNER);
    let mut files = vec![];
    for (k, threads) in ["1", "2", "8", "2"].into_iter().enumerate() {
        let out = folder.path(&format!("{k}/corner.step"));
        std::fs::create_dir(out.parent().unwrap()).unwrap();
        let run = export(&graph, &["-o", out.to_str().unwrap(), "--threads", threads, "--quiet"]);
        assert!(run.status.success(), "{}", stderr(&run));
        assert!(run.stdout.is_empty() && run.stderr.is_empty());
        files.push(std::fs::read(out).unwrap());
    }
    assert!(files[0].len() > 10_000);
    assert!(files.iter().all(|f| f == &files[0]));
}

#[test]
fn memory_changes_no_byte_and_too_little_is_said() {
    let folder = Folder::new();
    let graph = folder.write("corner.json", CORNER);
    let file = |name: &str, more: &[&str]| {
        let out = folder.path(name).join("corner.step");
        std::fs::create_dir(out.parent().unwrap()).unwrap();
        let run = export(&graph, &[&["-o", out.to_str().unwrap()], more].concat());
        assert!(run.status.success(), "{}", stderr(&run));
        (std::fs::read(out).unwrap(), stderr(&run))
    };
    let (free, quiet) = file("free", &[]);
    let (enough, as_quiet) = file("enough", &["--max-memory", "500"]);
    let (little, said) = file("little", &["--max-memory", "1"]);
    assert!(free == enough && free == little);
    assert!(!quiet.contains("--max-memory") && !as_quiet.contains("--max-memory"));
    assert!(said.contains("note: --max-memory: 1 MB: this lattice may take 8"), "{said}");
    assert_eq!(export(&graph, &["--max-memory", "0"]).status.code(), Some(2));
}

#[test]
fn the_report_agrees_with_the_solid_and_fits_its_schema() {
    let folder = Folder::new();
    let graph = folder.write("corner.json", CORNER);
    let report = folder.path("r.json");
    let run = export(&graph, &["--report", report.to_str().unwrap()]);
    assert!(run.status.success(), "{}", stderr(&run));
    assert_eq!(folder.names(), ["corner.json", "corner.step", "r.json"]);
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(report).unwrap()).unwrap();
    let counts = &report["counts"];
    assert_eq!(counts["nodes"], 5);
    assert_eq!(counts["struts"], 4);
    assert_eq!(counts["cylinders"], 4);
    assert_eq!(counts["circles"], 8);
    assert_eq!(counts["caps"], 3);
    assert_eq!(counts["components"], 1);
    assert_eq!(counts["genus"], 0);
    assert_eq!(counts["faces"].as_u64().unwrap(), 4 + 3 + counts["patches"].as_u64().unwrap());
    let volume = report["volume_mm3"].as_f64().unwrap();
    let struts = std::f64::consts::PI * (30.0 + 73f64.sqrt());
    assert!((0.85 * struts..1.05 * struts).contains(&volume), "{volume} against {struts}");
    assert!(report["quality"]["inner_jump_deg"]["value"].as_f64().unwrap() < 1e-6);
    assert_eq!(report["rungs"]["soap_film"], 2);
    assert_eq!(report["bytes"].as_u64().unwrap(), std::fs::metadata(folder.path("corner.step")).unwrap().len());
    let schema: serde_json::Value = serde_json::from_str(&lattice_brep::report::schema()).unwrap();
    for name in schema["required"].as_array().unwrap() {
        assert!(report.get(name.as_str().unwrap()).is_some(), "{name}");
    }
}

#[test]
fn bad_input_names_every_fault_exits_2_and_writes_nothing() {
    let faults = [
        ("not JSON", "no lattice", "document"),
        ("missing field", r#"{"units":"mm","nodes":[[0,0,0],[1,0,0]],"struts":[{"a":0,"b":1,"ra":0.1}]}"#, "struts[0]"),
        ("index out of range", r#"{"units":"mm","nodes":[[0,0,0],[9,0,0]],"struts":[{"a":0,"b":7,"ra":0.1,"rb":0.1}]}"#, "struts[0].b"),
        ("radius", r#"{"units":"mm","nodes":[[0,0,0],[9,0,0]],"struts":[{"a":0,"b":1,"ra":-1,"rb":-1}]}"#, "struts[0].ra"),
    ];
    for (what, text, place) in faults {
        let folder = Folder::new();
        let graph = folder.write("bad.json", text);
        let run = export(&graph, &["--report", folder.path("r.json").to_str().unwrap()]);
        assert_eq!(run.status.code(), Some(2), "{what}: {}", stderr(&run));
        assert!(stderr(&run).contains(place), "{what}: {}", stderr(&run));
        assert_eq!(folder.names(), ["bad.json"], "{what}");
    }
}

#[test]
fn cuts_that_meet_are_negotiated_and_if_nothing_fits_refused_with_the_numbers() {
    let triangle = |radius: f64| {
        let strut = |a, b| format!(r#"{{"a":{a},"b":{b},"ra":{radius},"rb":{radius}}}"#);
        format!(r#"{{"units":"mm","nodes":[[0,0,0],[10,0,0],[5,8,0]],"struts":[{},{},{}]}}"#, strut(0, 1), strut(1, 2), strut(2, 0))
    };
    let folder = Folder::new();
    let run = export(&folder.write("thick.json", &triangle(3.0)), &[]);
    assert_eq!(run.status.code(), Some(3));
    let text = stderr(&run);
    assert!(text.contains("struts[0]: found cuts of at least") && text.contains("which is cut at"), "{text}");
    assert!(!folder.path("thick.step").exists());
    let report = folder.path("r.json");
    let run = export(&folder.write("thin.json", &triangle(2.3)), &["--report", report.to_str().unwrap()]);
    assert!(run.status.success(), "{}", stderr(&run));
    assert!(stderr(&run).contains("3 with a smaller lambda"), "{}", stderr(&run));
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(report).unwrap()).unwrap();
    let cuts = &report["cuts"];
    assert_eq!((cuts["preferred"].as_u64(), cuts["smaller_lambda"].as_u64()), (Some(0), Some(3)));
    assert_eq!(cuts["changed"].as_array().unwrap().len(), 3);
    assert_eq!(cuts["changed"][0]["means"], "smaller lambda");
    let mm = |when: &str| -> f64 { cuts["changed"][0][when].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).sum() };
    assert!(mm("before_mm") > 10.0 && mm("after_mm") < 10.0);
}

#[test]
fn shrunk_ends_are_in_the_report_with_before_and_after() {
    // two struts that cross, the upper one close to an end of the lower
    let folder = Folder::new();
    let graph = folder
        .write("crossing.json", r#"{"nodes":[[0,0,0],[20,0,0],[18,-10,1.6],[18,10,1.6]],"struts":[{"a":0,"b":1,"ra":1,"rb":1},{"a":2,"b":3,"ra":1,"rb":1}]}"#);
    let report = folder.path("r.json");
    assert_eq!(export(&graph, &[]).status.code(), Some(2), "refused by default");
    let run = export(&graph, &["--on-conflict", "shrink", "--report", report.to_str().unwrap()]);
    assert!(run.status.success(), "{}", stderr(&run));
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(report).unwrap()).unwrap();
    let shrunk = report["cuts"]["shrunk"].as_array().unwrap();
    let numbers = |list: &serde_json::Value| [0, 1].map(|k| list[k].as_f64().unwrap());
    let mut lost = 0.0;
    for s in shrunk {
        let frustum = |[a, b]: [f64; 2]| std::f64::consts::PI / 3.0 * 20.0 * (a * a + a * b + b * b);
        let volume = frustum(numbers(&s["before_mm"])) - frustum(numbers(&s["after_mm"]));
        assert!((s["volume_mm3"].as_f64().unwrap() - volume).abs() < 1e-9);
        lost += volume;
    }
    assert!((report["cuts"]["shrunk_volume_mm3"].as_f64().unwrap() - lost).abs() < 1e-9);
    assert_eq!((report["counts"]["cones"].as_u64(), report["counts"]["cylinders"].as_u64()), (Some(1), Some(1)));
    // two lone struts lose nothing else: 40 mm of radius 1
    assert!((report["volume_mm3"].as_f64().unwrap() + lost - 40.0 * std::f64::consts::PI).abs() < 1e-6);
}

#[test]
fn merging_that_goes_too_far_or_makes_struts_overlap_is_refused() {
    let folder = Folder::new();
    // every strut of this octet is too short for its cuts
    let octet =
        Command::new(env!("CARGO_BIN_EXE_lattice-brep")).args(["cell", "octet", "--size", "10", "--repeat", "2x2x2", "--radius", "2.1"]).output().unwrap();
    let octet = folder.write("octet.json", &String::from_utf8(octet.stdout).unwrap());
    let run = export(&octet, &["--on-conflict", "merge"]);
    assert_eq!(run.status.code(), Some(3));
    assert!(stderr(&run).contains("struts[") && stderr(&run).contains("mm that their cuts reach"), "{}", stderr(&run));
    // nodes 0 and 1 become one, and so strut 1 comes nearer to strut 5
    let arm = |x: f64, degrees: f64| format!("[{},{},0]", x + 20.0 * degrees.to_radians().cos(), 20.0 * degrees.to_radians().sin());
    let arms = [arm(0.0, 120.0), arm(0.0, -120.0), arm(0.3, 60.0), arm(0.3, -60.0)].join(",");
    let strut = |(a, b): (u32, u32)| format!(r#"{{"a":{a},"b":{b},"ra":1,"rb":1}}"#);
    let struts = |ends: &[(u32, u32)]| ends.iter().map(|&e| strut(e)).collect::<Vec<_>>().join(",");
    let across = "[-0.225,4.489,-8],[-0.225,4.489,8]";
    let ends = [(0, 1), (0, 2), (0, 3), (1, 4), (1, 5), (6, 7)];
    let graph = |struts: String| format!(r#"{{"nodes":[[0,0,0],[0.3,0,0],{arms},{across}],"struts":[{struts}]}}"#);
    let alone = folder.write("alone.json", &graph(struts(&ends[..5])));
    let run = export(&alone, &["--on-conflict", "merge"]);
    assert!(run.status.success(), "{}", stderr(&run));
    let crossed = folder.write("crossed.json", &graph(struts(&ends)));
    // as given the arms overlap where their nodes are too near, but none of them the strut across
    assert!(!stderr(&export(&crossed, &[])).contains("struts[5]"));
    let run = export(&crossed, &["--on-conflict", "merge", "-o", folder.path("out.step").to_str().unwrap()]);
    assert_eq!(run.status.code(), Some(2));
    assert!(stderr(&run).contains("struts[4]: found its axis 1.9") && !folder.path("out.step").exists(), "{}", stderr(&run));
    assert!(stderr(&run).contains("help: `--on-conflict merge,shrink`"), "{}", stderr(&run));
}

#[test]
fn merge_and_shrink_together_build_what_neither_can() {
    // two nodes so near that no radii part their other struts, and a strut that crosses one of these
    let folder = Folder::new();
    let nodes = "[0,0,0],[0.05,0,0],[-10,17,0],[-10,-17,0],[10,17,0],[10,-17,0],[5,10,-8],[5,10,8]";
    let ends = [(0, 1), (0, 2), (0, 3), (1, 4), (1, 5), (6, 7)].map(|(a, b)| format!(r#"{{"a":{a},"b":{b},"ra":1,"rb":1}}"#)).join(",");
    let graph = folder.write("foam.json", &format!(r#"{{"nodes":[{nodes}],"struts":[{ends}]}}"#));
    for (policy, code) in [("refuse", 2), ("shrink", 3), ("merge", 2)] {
        let run = export(&graph, &["--on-conflict", policy]);
        assert_eq!(run.status.code(), Some(code), "{policy}: {}", stderr(&run));
        assert!(stderr(&run).contains("help: ") && stderr(&run).contains("merge,shrink"), "{policy}: {}", stderr(&run));
    }
    let report = folder.path("r.json");
    let run = export(&graph, &["--on-conflict", "merge,shrink", "--report", report.to_str().unwrap()]);
    assert!(run.status.success(), "{}", stderr(&run));
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(report).unwrap()).unwrap();
    assert_eq!(report["repairs"].as_array().unwrap().len(), 1);
    assert!(!report["cuts"]["shrunk"].as_array().unwrap().is_empty());
    assert_eq!((report["counts"]["struts"].as_u64(), report["counts"]["components"].as_u64()), (Some(5), Some(2)));
}

#[test]
fn an_output_folder_that_is_not_there_is_our_failure_and_options_are_checked() {
    let folder = Folder::new();
    let graph = folder.write("corner.json", CORNER);
    let run = export(&graph, &["-o", folder.path("no/such/out.step").to_str().unwrap()]);
    assert_eq!(run.status.code(), Some(1), "{}", stderr(&run));
    let run = export(&graph, &["--lambda", "0.7", "--tolerance", "0"]);
    assert_eq!(run.status.code(), Some(2));
    assert!(stderr(&run).contains("--lambda") && stderr(&run).contains("--tolerance"), "{}", stderr(&run));
    assert_eq!(folder.names(), ["corner.json"]);
}

#[test]
fn every_schema_and_both_caps_can_be_read_back() {
    let folder = Folder::new();
    let graph = folder.write("corner.json", CORNER);
    for (schema, name) in [("ap242", "AP242_MANAGED"), ("ap214", "AUTOMOTIVE_DESIGN"), ("ap203", "CONFIG_CONTROL_DESIGN")] {
        for caps in ["flat", "sphere"] {
            let out = folder.path("out.step");
            let run = export(&graph, &["-o", out.to_str().unwrap(), "--schema", schema, "--caps", caps, "--quiet"]);
            assert!(run.status.success(), "{}", stderr(&run));
            let check = Command::new(env!("CARGO_BIN_EXE_lattice-brep")).arg("check").arg(&out).output().unwrap();
            let text = String::from_utf8(check.stdout).unwrap();
            assert!(check.status.success() && text.contains(name), "{text}");
            assert!(text.contains("edges not used twice in opposite senses: 0"), "{text}");
            assert!(text.contains("cylinders 4"), "{text}");
        }
    }
}

#[test]
fn a_crop_cuts_struts_into_free_ends() {
    let folder = Folder::new();
    let graph = folder.write("corner.json", CORNER);
    let out = folder.path("part.step");
    let report = folder.path("r.json");
    let run = export(&graph, &["-o", out.to_str().unwrap(), "--crop", "-2,-2,-2:6,6,6", "--report", report.to_str().unwrap()]);
    assert!(run.status.success(), "{}", stderr(&run));
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(report).unwrap()).unwrap();
    assert_eq!(report["counts"]["struts"], 3);
    assert_eq!(report["counts"]["caps"], 3);
    let run = export(&graph, &["-o", out.to_str().unwrap(), "--crop", "50,50,50:60,60,60"]);
    assert_eq!(run.status.code(), Some(2), "{}", stderr(&run));
}

#[test]
fn two_parts_become_two_solids_in_one_file() {
    let folder = Folder::new();
    let graph = folder.write(
        "two.json",
        r#"{"units":"mm","nodes":[[0,0,0],[10,0,0],[0,0,20],[10,0,20]],"struts":[{"a":0,"b":1,"ra":1,"rb":1},{"a":2,"b":3,"ra":0.5,"rb":0.5}]}"#,
    );
    let report = folder.path("r.json");
    let run = export(&graph, &["--report", report.to_str().unwrap()]);
    assert!(run.status.success(), "{}", stderr(&run));
    assert!(stderr(&run).contains("2 solids"), "{}", stderr(&run));
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(report).unwrap()).unwrap();
    let solids = report["solids"].as_array().unwrap();
    for (solid, (first_node, radius)) in solids.iter().zip([(0, 1.0), (2, 0.5f64)]) {
        assert_eq!((solid["first_node"].as_u64(), solid["nodes"].as_u64(), solid["struts"].as_u64()), (Some(first_node), Some(2), Some(1)));
        let volume = 10.0 * std::f64::consts::PI * radius.powi(2);
        assert!((solid["volume_mm3"].as_f64().unwrap() / volume - 1.0).abs() < 1e-9);
    }
    assert_eq!(solids.len(), 2);
}

#[test]
#[cfg(unix)]
fn an_interrupt_leaves_nothing_behind() {
    let folder = Folder::new();
    let graph = folder.path("octet.json");
    let cell = ["cell", "octet", "--size", "10", "--repeat", "6x6x6", "--radius", "0.5", "-o"];
    assert!(Command::new(env!("CARGO_BIN_EXE_lattice-brep")).args(cell).arg(&graph).status().unwrap().success());
    let mut run = Command::new(env!("CARGO_BIN_EXE_lattice-brep")).args(["export", "--quiet"]).arg(&graph).spawn().unwrap();
    // ready before it is needed: a new process may take longer than the writing on a busy machine
    let mut killer = Command::new("sh").args(["-c", "read go; kill -INT $0", &run.id().to_string()]).stdin(std::process::Stdio::piped()).spawn().unwrap();
    // while the file is being written
    while folder.names().len() < 2 {
        assert!(run.try_wait().unwrap().is_none(), "ended before it wrote anything");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert!(folder.names()[0].starts_with(".lattice-brep-"), "{:?}", folder.names());
    std::io::Write::write_all(&mut killer.stdin.take().unwrap(), b"go\n").unwrap();
    assert!(killer.wait().unwrap().success());
    assert_eq!(run.wait().unwrap().code(), Some(130));
    assert_eq!(folder.names(), ["octet.json"]);
}

#[test]
fn a_compressed_file_holds_the_bytes_of_the_plain_one() {
    let (folder, plain) = (Folder::new(), Folder::new());
    let input = folder.write("corner.json", CORNER);
    for (name, into) in [("part.stp", &plain), ("part.stpZ", &folder)] {
        let out = export(&input, &["-q", "-o", into.path(name).to_str().unwrap()]);
        assert!(out.status.success(), "{}", stderr(&out));
    }
    let packed = folder.path("part.stpZ");
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&packed).unwrap()).unwrap();
    assert_eq!((archive.len(), archive.by_index(0).unwrap().name().unwrap().as_ref()), (1, "part.stp"));
    let mut text = vec![];
    std::io::Read::read_to_end(&mut archive.by_index(0).unwrap(), &mut text).unwrap();
    assert!(text == std::fs::read(plain.path("part.stp")).unwrap());
    assert!(2 * packed.metadata().unwrap().len() < text.len() as u64);

    let check = |path: &Path| Command::new(env!("CARGO_BIN_EXE_lattice-brep")).arg("check").arg(path).output().unwrap();
    let (a, b) = (check(&packed), check(&plain.path("part.stp")));
    assert!(a.status.success() && a.stdout == b.stdout, "{}", stderr(&a));
}

/// A larger ball fills more and leaves rounder valleys, listed for each node; lambda grows with it where it must.
#[test]
fn a_blend_rounds_the_valleys() {
    let folder = Folder::new();
    let report = folder.path("r.json");
    let step = folder.path("r.step");
    let mut found = vec![];
    for blend in ["0", "0.1", "0.2", "0.3"] {
        let run = export(Path::new("tests/examples/irregular.json"), &["--blend", blend, "-o", step.to_str().unwrap(), "--report", report.to_str().unwrap()]);
        assert!(run.status.success(), "{}", stderr(&run));
        let json: serde_json::Value = serde_json::from_slice(&std::fs::read(&report).unwrap()).unwrap();
        assert_eq!(json["valleys"][0]["radius_mm"], json["concave_radius_mm"]["value"]);
        assert_eq!(json["rungs"]["soap_film"], 1);
        found.push(["/concave_radius_mm/value", "/added_mm3"].map(|at| json.pointer(at).unwrap().as_f64().unwrap()));
    }
    assert!(found.windows(2).all(|w| w[1][0] > w[0][0] && w[1][1] > w[0][1]), "{found:?}");
    for (options, wanted) in
        [(["--blend", "0.4"], "a number from 0 to 0.36"), (["--blend", "nan"], "a number from 0 to 0.36"), (["--blend=0.3", "--lambda=0.3"], "at least 0.4000")]
    {
        let run = export(Path::new("tests/examples/irregular.json"), &options);
        assert_eq!(run.status.code(), Some(2));
        assert!(stderr(&run).contains(wanted), "{}", stderr(&run));
    }
    assert!(!folder.names().iter().any(|n| n.contains("irregular")));
}
