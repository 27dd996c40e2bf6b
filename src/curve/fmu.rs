//! The curve as a functional mock-up unit: FMI 2.0 for model exchange and co-simulation.
//!
//! | place in the archive | what it holds |
//! |---|---|
//! | `modelDescription.xml` | depth, velocity, damping in; force, stiffness, area out; directional derivatives |
//! | `sources/` | everything a C compiler needs; no header of the standard |
//! | `binaries/PLATFORM/` | a library built from them, where one was handed in |
//! | `documentation/index.html` | what the curve is of, and how good it is |

use std::fmt::Write as _;
use std::io::{self, Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::Curve;
use super::export::About;
use super::header::identifier;

/// The functions of the standard, over those of the header.
const FUNCTIONS: &str = include_str!("fmi2.c.in");

/// A library for one platform.
#[derive(Debug, Clone, Copy)]
pub struct Binary<'a> {
    /// The directory of the standard: `linux64`, `darwin64`, `win64`.
    pub platform: &'a str,
    /// Ending of the file: `so`, `dylib`, `dll`.
    pub ending: &'a str,
    /// The library.
    pub bytes: &'a [u8],
}

/// A file of C.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// Name of the file.
    pub name: String,
    /// Its text.
    pub text: String,
}

impl Curve {
    /// The C sources of the unit: one file to compile, `NAME_fmi2.c`, then the header that it includes.
    #[must_use]
    pub fn fmu_sources(&self, about: About, name: &str) -> [Source; 2] {
        let n = identifier(name);
        let header = self.c_header_about(about, name);
        let functions = FUNCTIONS
            .replace("@GUID@", &guid(&header))
            .replace("@START@", &format!("{:e}", self.start()))
            .replace("@GUARD@", &n.to_uppercase())
            .replace("@NAME@", &n);
        [
            Source { name: format!("{n}_fmi2.c"), text: functions },
            Source { name: format!("{n}_spring.h"), text: header },
        ]
    }

    /// The unit as a zip archive, with a binary or with sources alone. The same curve makes the same bytes.
    ///
    /// ```
    /// use contact_patch::{Contact, Curve, EffectiveModulus, Loading, Settings, curve::{About, Beyond}, gap::Paraboloid};
    /// let sphere = Contact::new(EffectiveModulus::from_e_star(1.0)?, Paraboloid::new([1.0, 1.0])?, Loading::depth(1.0))?;
    /// let spring = Curve::up_to(&sphere, &Settings::default(), 1.0, 1e-4)?.continued(Beyond::Power);
    /// let unit = spring.fmu(About::default(), "sphere", None)?;
    /// assert_eq!(&unit[..2], b"PK");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// When the archive cannot be written.
    pub fn fmu(&self, about: About, name: &str, binary: Option<Binary>) -> io::Result<Vec<u8>> {
        let n = identifier(name);
        let sources = self.fmu_sources(about, name);
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let mut file = |path: String, bytes: &[u8]| {
            // The default time of a file in a zip is its first, the same for all.
            let options = SimpleFileOptions::default()
                .compression_method(CompressionMethod::Deflated)
                .last_modified_time(zip::DateTime::default());
            archive.start_file(path, options)?;
            archive.write_all(bytes)
        };
        file("modelDescription.xml".to_owned(), self.model_description(about, &n, &sources).as_bytes())?;
        for source in &sources {
            file(format!("sources/{}", source.name), source.text.as_bytes())?;
        }
        if let Some(binary) = binary {
            file(format!("binaries/{}/{n}.{}", binary.platform, binary.ending), binary.bytes)?;
        }
        let page = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{n}</title></head><body>\n<h1>{n}</h1>\n\
             <p>A contact as a non-linear spring: depth, velocity and damping in; force, stiffness and area out.</p>\n<pre>\n{}\n</pre>\n\
             </body></html>\n",
            xml(&self.provenance(about).replace(" * ", ""))
        );
        file("documentation/index.html".to_owned(), page.as_bytes())?;
        Ok(archive.finish()?.into_inner())
    }

    /// The depth that it starts at: no contact.
    fn start(&self) -> f64 {
        self.first_touch.min(0.0)
    }

    fn model_description(&self, about: About, n: &str, [functions, header]: &[Source; 2]) -> String {
        let units = about.units.map(|u| {
            [u.length().to_owned(), format!("{}/s", u.length()), u.force().to_owned(), u.stiffness(), u.area()]
        });
        let unit = |k: usize| units.as_ref().map_or(String::new(), |units| format!(" unit=\"{}\"", xml(&units[k])));
        let definitions = units.as_ref().map_or(String::new(), |units| {
            let names: Vec<String> = units.iter().map(|u| format!("    <Unit name=\"{}\"/>\n", xml(u))).collect();
            format!("  <UnitDefinitions>\n{}  </UnitDefinitions>\n", names.concat())
        });
        let scene = about.scene.map_or(String::new(), |scene| format!(" of {}", xml(scene)));
        let flags = "canBeInstantiatedOnlyOncePerProcess=\"false\" canNotUseMemoryManagementFunctions=\"true\" \
                     canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\" providesDirectionalDerivative=\"true\"";
        let files = format!("    <SourceFiles>\n      <File name=\"{}\"/>\n    </SourceFiles>\n", functions.name);
        let start = self.start();
        let mut variables = String::new();
        let inputs = [
            ("depth", "causality=\"input\" variability=\"continuous\"", unit(0), start, "approach of the bodies"),
            (
                "velocity",
                "causality=\"input\" variability=\"continuous\"",
                unit(1),
                0.0,
                "its rate; damping alone needs it",
            ),
        ];
        for (k, (name, kind, unit, start, text)) in inputs.into_iter().enumerate() {
            let _ = write!(
                variables,
                "    <ScalarVariable name=\"{name}\" valueReference=\"{k}\" {kind} description=\"{text}\">\n      \
                 <Real{unit} start=\"{start:e}\"/>\n    </ScalarVariable>\n"
            );
        }
        variables.push_str(
            "    <ScalarVariable name=\"damping\" valueReference=\"2\" causality=\"parameter\" variability=\"tunable\" initial=\"exact\" \
             description=\"c of Hunt and Crossley: the force is (1 + c velocity) times that of the contact at rest, never a pull; time over length\">\n      \
             <Real start=\"0\" min=\"0\"/>\n    </ScalarVariable>\n",
        );
        let outputs = [
            (3, "force", unit(2), "force of the contact, with damping"),
            (4, "stiffness", unit(3), "derivative of the force at rest by the depth"),
            (5, "area", unit(4), "area of the contact patch"),
        ];
        for (k, name, unit, text) in outputs {
            let _ = write!(
                variables,
                "    <ScalarVariable name=\"{name}\" valueReference=\"{k}\" causality=\"output\" variability=\"continuous\" initial=\"calculated\" \
                 description=\"{text}\">\n      <Real{unit}/>\n    </ScalarVariable>\n"
            );
        }
        let touch = self.first_touch;
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <fmiModelDescription fmiVersion=\"2.0\" modelName=\"{n}\" guid=\"{}\" version=\"{version}\"\n  \
             description=\"Contact{scene} as a non-linear spring: first touch at depth {touch:e}, solved to {deepest:e}, force to {force:.1e}, stiffness to {stiffness:.1e} (relative)\"\n  \
             generationTool=\"contact-patch {version}\" variableNamingConvention=\"flat\" numberOfEventIndicators=\"1\">\n  \
             <ModelExchange modelIdentifier=\"{n}\" completedIntegratorStepNotNeeded=\"true\" {flags}>\n{files}  </ModelExchange>\n  \
             <CoSimulation modelIdentifier=\"{n}\" canHandleVariableCommunicationStepSize=\"true\" {flags}>\n{files}  </CoSimulation>\n\
             {definitions}  \
             <LogCategories>\n    <Category name=\"logStatusError\"/>\n  </LogCategories>\n  \
             <DefaultExperiment startTime=\"0\" stopTime=\"1\"/>\n  \
             <ModelVariables>\n{variables}  </ModelVariables>\n  \
             <ModelStructure>\n    <Outputs>\n{outputs}    </Outputs>\n    <InitialUnknowns>\n{unknowns}    </InitialUnknowns>\n  \
             </ModelStructure>\n</fmiModelDescription>\n",
            guid(&header.text),
            version = env!("CARGO_PKG_VERSION"),
            deepest = self.deepest(),
            force = self.interpolation_error(),
            stiffness = self.stiffness_error(),
            outputs = "      <Unknown index=\"4\" dependencies=\"1 2\"/>\n      <Unknown index=\"5\" dependencies=\"1\"/>\n      \
                       <Unknown index=\"6\" dependencies=\"1\"/>\n",
            unknowns = "      <Unknown index=\"4\" dependencies=\"1 2 3\"/>\n      <Unknown index=\"5\" dependencies=\"1\"/>\n      \
                        <Unknown index=\"6\" dependencies=\"1\"/>\n",
        )
    }
}

/// A name that differs where the header does: two FNV-1a hashes (Fowler, Noll & Vo) in the form of a GUID.
fn guid(text: &str) -> String {
    let hash = |basis: u64| text.bytes().fold(basis, |h, byte| (h ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    let (a, b) = (hash(0xcbf2_9ce4_8422_2325), hash(0x6c62_272e_07bb_0142));
    format!(
        "{{{:08x}-{:04x}-{:04x}-{:04x}-{:012x}}}",
        a >> 32,
        (a >> 16) & 0xffff,
        a & 0xffff,
        b >> 48,
        b & 0xffff_ffff_ffff
    )
}

/// A text as it stands in XML.
fn xml(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            // Not even escaped does XML 1.0 hold them.
            c if c.is_control() && c != '\n' || matches!(c, '\u{fffe}' | '\u{ffff}') => safe.push(' '),
            c => safe.push(c),
        }
    }
    safe
}
