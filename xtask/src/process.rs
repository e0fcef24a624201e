//! Runs a command with its output in a log and, if wanted, a time limit that also ends what the command started.

use std::fs::OpenOptions;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// How a command ended.
#[derive(Debug)]
pub enum Ending {
    /// By itself.
    Exited(ExitStatus),
    /// It was ended at the time limit.
    TimedOut,
}

impl Ending {
    /// Whether the command ended by itself with exit code 0.
    pub fn success(&self) -> bool {
        matches!(self, Self::Exited(status) if status.success())
    }
}

/// Runs the command without standard input, appends what it prints to the log, and returns that too.
pub fn run(command: &mut Command, log: &Path, limit: Option<Duration>) -> io::Result<(Ending, String)> {
    let mut file = OpenOptions::new().create(true).append(true).read(true).open(log)?;
    writeln!(file, "$ {}", as_typed(command))?;
    let begin_of_output = file.seek(SeekFrom::End(0))?;
    command.stdin(Stdio::null()).stdout(file.try_clone()?).stderr(file.try_clone()?);
    let mut child = command.spawn()?;
    let ending = match limit {
        None => Ending::Exited(child.wait()?),
        Some(limit) => wait_at_most(&mut child, limit)?,
    };
    file.seek(SeekFrom::Start(begin_of_output))?;
    let mut output = Vec::new();
    file.read_to_end(&mut output)?;
    if matches!(ending, Ending::TimedOut) {
        writeln!(file, "\n(ended at the time limit)")?;
    }
    Ok((ending, String::from_utf8_lossy(&output).into_owned()))
}

/// The program and its arguments as a person would type them.
fn as_typed(command: &Command) -> String {
    let words: Vec<_> = command.get_args().map(|word| word.to_string_lossy()).collect();
    let program = Path::new(command.get_program()).file_stem().unwrap_or_default().to_string_lossy();
    format!("{program} {}", words.join(" "))
}

/// Waits for the child; at the limit, ends it and everything below it.
fn wait_at_most(child: &mut Child, limit: Duration) -> io::Result<Ending> {
    let begin = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Ending::Exited(status));
        }
        if begin.elapsed() > limit {
            let below = descendants(child.id());
            child.kill()?;
            child.wait()?;
            end(&below);
            return Ok(Ending::TimedOut);
        }
        thread::sleep(Duration::from_millis(20));
    }
}

/// The processes that a process started, and those that they started.
fn descendants(ancestor: u32) -> Vec<u32> {
    let table = processes();
    let mut found = vec![ancestor];
    let mut place = 0;
    while place < found.len() {
        let parent = found[place];
        found.extend(table.iter().filter(|(_, of)| *of == parent).map(|(process, _)| *process));
        place += 1;
    }
    found.split_off(1)
}

/// Every process with its parent: from `ps`, or from `/proc` where a small system has no `ps`.
fn processes() -> Vec<(u32, u32)> {
    let listed = Command::new("ps").args(["-A", "-o", "pid=,ppid="]).stdin(Stdio::null()).output();
    if let Ok(listed) = listed
        && listed.status.success()
    {
        return String::from_utf8_lossy(&listed.stdout).lines().filter_map(two_numbers).collect();
    }
    let Ok(entries) = std::fs::read_dir("/proc") else {
        return Vec::new();
    };
    entries
        .filter_map(|entry| {
            let path = entry.ok()?.path();
            let process = path.file_name()?.to_str()?.parse().ok()?;
            // "PID (NAME) STATE PARENT …", where the name may hold anything, parentheses included.
            let status = std::fs::read_to_string(path.join("stat")).ok()?;
            let parent = status.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()?;
            Some((process, parent))
        })
        .collect()
}

/// The first two numbers of a line.
fn two_numbers(line: &str) -> Option<(u32, u32)> {
    let mut words = line.split_whitespace().map(str::parse);
    Some((words.next()?.ok()?, words.next()?.ok()?))
}

/// Ends processes by their numbers. One that is gone already is no error.
fn end(processes: &[u32]) {
    if !processes.is_empty() {
        let mut command = Command::new("sh");
        command.args(["-c", "kill -KILL \"$@\"", "sh"]).args(processes.iter().map(u32::to_string));
        // Nothing can be done about a process that cannot be ended: the verdict stays "hangs".
        let _ = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status();
    }
}
