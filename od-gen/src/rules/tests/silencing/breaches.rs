//! What breaks each rule: the nearest change of a data sheet, a binding or a configuration that keeps it.

/// A rule, and what becomes what in a data sheet that keeps it.
pub(super) type Change = (&'static str, &'static [(&'static str, &'static str)]);

/// The rules that are checked while a data sheet is read.
pub(super) const CHANGES: &[Change] = &[
    ("not-utf-8", &[("VendorName=Nobody", "VendorName=Nöbody")]),
    (
        "control-character",
        &[("VendorName=Nobody", "VendorName=No\u{1}body")],
    ),
    (
        "stray-line",
        &[("Granularity=8", "Granularity=8\nnonsense")],
    ),
    ("unclosed-section", &[("[DummyUsage]", "[DummyUsage] x")]),
    ("key-before-section", &[("[FileInfo]", "a=1\n[FileInfo]")]),
    (
        "trailing-comment",
        &[("Granularity=8", "Granularity=8 ; why")],
    ),
    (
        "repeated-section",
        &[("[2000]", "[FileInfo]\nFileName=other.eds\n\n[2000]")],
    ),
    (
        "repeated-key",
        &[("FileVersion=1", "FileVersion=1\nFileVersion=1")],
    ),
    (
        "contradicting-key",
        &[("FileVersion=1", "FileVersion=1\nFileVersion=2")],
    ),
    ("unknown-section", &[("[2000]", "[Maker]\na=1\n\n[2000]")]),
    (
        "unknown-key",
        &[("FileVersion=1", "FileVersion=1\nColour=blue")],
    ),
    (
        "key-of-a-dcf",
        &[("ParameterName=Type", "ParameterName=Type\nParameterValue=1")],
    ),
    (
        "allowance-without-reason",
        &[(
            "ParameterName=Type",
            ";od-gen: allow storage\nParameterName=Type",
        )],
    ),
    (
        "allowance-of-no-rule",
        &[(
            "ParameterName=Type",
            ";od-gen: allow it because so\nParameterName=Type",
        )],
    ),
    (
        "allowance-refused",
        &[(
            "ParameterName=Type",
            ";od-gen: allow not-xml because so\nParameterName=Type",
        )],
    ),
    (
        "unused-allowance",
        &[(
            "ParameterName=Type",
            ";od-gen: allow storage because so\nParameterName=Type",
        )],
    ),
    (
        "missing-file-info",
        &[(
            "[FileInfo]\nFileName=small.eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\n",
            "",
        )],
    ),
    ("list-numbering", &[("12=0x200B", "13=0x200B")]),
    (
        "list-count",
        &[("SupportedObjects=12", "SupportedObjects=11")],
    ),
    (
        "not-an-index",
        &[
            ("SupportedObjects=12", "SupportedObjects=13"),
            ("12=0x200B", "12=0x200B\n13=x"),
        ],
    ),
    (
        "listed-twice",
        &[
            ("SupportedObjects=12", "SupportedObjects=13"),
            ("12=0x200B", "12=0x200B\n13=0x200B"),
        ],
    ),
    (
        "wrong-list",
        &[
            ("SupportedObjects=6", "SupportedObjects=7"),
            ("6=0x1A00", "6=0x1A00\n7=0x200B"),
            ("SupportedObjects=12", "SupportedObjects=11"),
            ("\n12=0x200B", ""),
        ],
    ),
    (
        "listed-without-section",
        &[
            ("SupportedObjects=12", "SupportedObjects=13"),
            ("12=0x200B", "12=0x200B\n13=0x2010"),
        ],
    ),
    (
        "not-listed",
        &[
            ("SupportedObjects=12", "SupportedObjects=11"),
            ("\n12=0x200B", ""),
        ],
    ),
    ("object-type", &[("ObjectType=8", "ObjectType=ARRAY")]),
    (
        "type-definition",
        &[(
            "[200B]",
            "[0050]\nParameterName=Odd\nObjectType=7\nDataType=5\nAccessType=ro\n\n[200B]",
        )],
    ),
    (
        "sub-without-object",
        &[(
            "[200B]",
            "[2010sub1]\nParameterName=Odd\nDataType=5\nAccessType=ro\n\n[200B]",
        )],
    ),
    (
        "subs-of-a-variable",
        &[(
            "[200B]",
            "[2000sub1]\nParameterName=Odd\nDataType=5\nAccessType=ro\n\n[200B]",
        )],
    ),
    (
        "sub-number",
        &[("ObjectType=8\nSubNumber=3", "ObjectType=8\nSubNumber=4")],
    ),
    (
        "no-sub-number",
        &[("ObjectType=8\nSubNumber=3", "ObjectType=8")],
    ),
    (
        "no-sub-0",
        &[
            ("ObjectType=8\nSubNumber=3", "ObjectType=8\nSubNumber=2"),
            (
                "[200ASub0]\nParameterName=Highest sub-index supported\nDataType=0x0005\nAccessType=const\nDefaultValue=0x2\n",
                "",
            ),
        ],
    ),
    (
        "sub-0-type",
        &[(
            "0x0005\nAccessType=const\nDefaultValue=0x2\n",
            "0x0006\nAccessType=const\nDefaultValue=0x2\n",
        )],
    ),
    (
        "sub-0-value",
        &[("DefaultValue=0x2\n", "DefaultValue=0x3\n")],
    ),
    (
        "sub-ff",
        &[
            ("ObjectType=8\nSubNumber=3", "ObjectType=8\nSubNumber=4"),
            (
                "[200B]",
                "[200AsubFF]\nParameterName=Structure\nDataType=4\nAccessType=ro\n\n[200B]",
            ),
        ],
    ),
    (
        "sub-object-type",
        &[("[200AsUB2]\n", "[200AsUB2]\nObjectType=8\n")],
    ),
    (
        "array-of-many-types",
        &[(
            "[200AsUB2]\nParameterName=Element\nDataType=0x0004",
            "[200AsUB2]\nParameterName=Element\nDataType=3",
        )],
    ),
    (
        "compact-and-subs",
        &[(
            "ObjectType=8\nSubNumber=3",
            "ObjectType=8\nCompactSubObj=2\nDataType=4\nAccessType=rw",
        )],
    ),
    (
        "compact-list",
        &[("[200B]", "[200AName]\nNrOfEntries=0\n\n[200B]")],
    ),
    ("no-name", &[("ParameterName=Type\n", "")]),
    (
        "plain-name",
        &[("ParameterName=Type\n", "ParameterName=?!\n")],
    ),
    (
        "header-key",
        &[(
            "ObjectType=8\nSubNumber=3",
            "ObjectType=8\nSubNumber=3\nAccessType=rw",
        )],
    ),
    ("file-version", &[("FileVersion=1\n", "FileVersion=1.0\n")]),
    (
        "no-module",
        &[("[200B]", "[ConnectedModules]\nNrOfEntries=0\n1=5\n\n[200B]")],
    ),
    (
        "not-a-number",
        &[(
            "LowLimit=-5\nDefaultValue=-1",
            "LowLimit=low\nDefaultValue=-1",
        )],
    ),
    (
        "not-a-number",
        &[(
            "LowLimit=-5\nDefaultValue=-1",
            "LowLimit=-5\nDefaultValue=none",
        )],
    ),
    (
        "not-a-number",
        &[(
            "ParameterName=Type\nDataType=0x0001",
            "ParameterName=Type\nDataType=BOOLEAN",
        )],
    ),
    (
        "not-a-number",
        &[(
            "ParameterName=Type\nDataType=0x0001",
            "ParameterName=Type\nDataType=some",
        )],
    ),
    (
        "not-a-number",
        &[(
            "Type\nDataType=0x0001\nAccessType=rw\nDefaultValue=1",
            "Type\nDataType=8\nAccessType=rw\nDefaultValue=1,5",
        )],
    ),
    (
        "not-a-number",
        &[(
            "ObjectType=8\nSubNumber=3",
            "ObjectType=8\nSubNumber=3\nObjFlags=no",
        )],
    ),
    ("out-of-range", &[("Granularity=8", "Granularity=99")]),
    (
        "no-data-type",
        &[(
            "ParameterName=Type\nDataType=0x0001\n",
            "ParameterName=Type\n",
        )],
    ),
    (
        "data-type",
        &[(
            "ParameterName=Type\nDataType=0x0001",
            "ParameterName=Type\nDataType=0x0020",
        )],
    ),
    (
        "data-type",
        &[(
            "[200AsUB2]\nParameterName=Element\nDataType=0x0004",
            "[200AsUB2]\nParameterName=Element\nDataType=0x40",
        )],
    ),
    (
        "data-type",
        &[(
            "[200B]\nParameterName=Flag\nDataType=0x0001",
            "[200B]\nParameterName=Flag\nObjectType=8\nCompactSubObj=2\nDataType=0x40",
        )],
    ),
    (
        "no-access",
        &[(
            "ParameterName=Type\nDataType=0x0001\nAccessType=rw\n",
            "ParameterName=Type\nDataType=0x0001\n",
        )],
    ),
    (
        "access-type",
        &[(
            "Type\nDataType=0x0001\nAccessType=rw",
            "Type\nDataType=0x0001\nAccessType=wr",
        )],
    ),
    (
        "mapping-of-variable-length",
        &[("ParameterName=Text", "ParameterName=Text\nPDOMapping=1")],
    ),
    (
        "default-type",
        &[(
            "LowLimit=-5\nDefaultValue=-1",
            "LowLimit=-5\nDefaultValue=256",
        )],
    ),
    (
        "limit-type",
        &[("HighLimit=200\nPDOMapping=1", "HighLimit=256\nPDOMapping=1")],
    ),
    (
        "limit-of-no-number",
        &[("ParameterName=Text", "ParameterName=Text\nLowLimit=1")],
    ),
    (
        "limit-of-node",
        &[(
            "DefaultValue=$NODEID\n",
            "LowLimit=$NODEID\nDefaultValue=$NODEID\n",
        )],
    ),
    (
        "value-of-a-domain",
        &[(
            "Text\nDataType=0x0009\nAccessType=rw",
            "Text\nDataType=0x000F\nAccessType=rw\nDefaultValue=x",
        )],
    ),
    (
        "low-above-high",
        &[("LowLimit=-5\nHighLimit=200", "LowLimit=-5\nHighLimit=-6")],
    ),
    (
        "default-outside-limits",
        &[(
            "LowLimit=-5\nDefaultValue=-1",
            "LowLimit=-5\nDefaultValue=-6",
        )],
    ),
    (
        "const-without-default",
        &[("AccessType=const\nDefaultValue=1\n", "AccessType=const\n")],
    ),
    (
        "node-id-type",
        &[("LowLimit=-5\nDefaultValue=-1", "DefaultValue=$NODEID")],
    ),
    (
        "node-id-room",
        &[("DefaultValue=$NODEID\n", "DefaultValue=$NODEID+0xFFF0\n")],
    ),
    (
        "string-spelling",
        &[("DefaultValue=hello", "DefaultValue=hëll")],
    ),
    (
        "octet-string-spelling",
        &[("DefaultValue=01 aB ff", "DefaultValue=bytes!")],
    ),
    ("capacity", &[(";Capacity=5", ";Capacity=five")]),
    (
        "capacity-of-no-string",
        &[("ParameterName=Flag", ";Capacity=5\nParameterName=Flag")],
    ),
    ("capacity-too-small", &[(";Capacity=5", ";Capacity=4")]),
    (
        "value-too-large",
        &[
            (";Capacity=5\n", ""),
            ("DefaultValue=hello", "DefaultValue=LONG"),
        ],
    ),
    ("storage", &[(";Capacity=5", ";Capacity=5\n;Storage=there")]),
    (
        "storage-of-a-fixed-value",
        &[(
            "ParameterName=Flag",
            ";Storage=application\nParameterName=Flag",
        )],
    ),
    (
        "memory",
        &[(
            "ParameterName=Flag",
            ";Memory=application\nParameterName=Flag",
        )],
    ),
    (
        "dictionary-too-large",
        &[("DefaultValue=01 aB ff", "DefaultValue=BYTES")],
    ),
];

/// Rules of bindings with a file that breaks them.
pub(super) const BINDINGS: &[(&str, &str)] = &[
    ("binding-syntax", "[[binding]]\nobject = 5\n"),
    (
        "binding-object",
        "[[binding]]\nobject = \"speed\"\nparameter = \"profile_velocity\"\n",
    ),
    (
        "binding-object-type",
        "[[binding]]\nobject = \"2010h\"\nparameter = \"profile_velocity\"\n",
    ),
    (
        "bound-twice",
        "[[binding]]\nobject = \"6083h\"\nparameter = \"profile_velocity\"\n",
    ),
    (
        "binding-parameter",
        "[[binding]]\nobject = \"2006h\"\nparameter = \"speed\"\n",
    ),
    (
        "binding-access",
        "[[binding]]\nobject = \"2006h\"\nparameter = \"statusword\"\n",
    ),
    (
        "binding-scale",
        "[[binding]]\nobject = \"2006h\"\nparameter = \"profile_velocity\"\nscale = 0\n",
    ),
    (
        "binding-values",
        "[[binding]]\nobject = \"2000h\"\nparameter = \"modes_of_operation\"\nvalues = {}\n",
    ),
    (
        "binding-range",
        "[[binding]]\nobject = \"2006h\"\nparameter = \"profile_velocity\"\nvalues = { 1 = 1 }\n",
    ),
    ("binding-habit", "[habits]\nmaps_while_valid = 5\n"),
    (
        "binding-storage",
        "[storage]\nobjects = [\"all\", \"2000h-5FFFh\"]\n",
    ),
    ("unbound-object", ""),
];

/// Rules of the values of a configuration with a line that breaks them.
pub(super) const VALUES: &[(&str, &str)] = &[
    ("value-line", "what is this\n"),
    ("value-of-nothing", "2FFF=1\n"),
    ("value-twice", "2001=1\n2001=2\n"),
];
