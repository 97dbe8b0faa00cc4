<?xml version="1.0" encoding="UTF-8"?>
<ISO15745ProfileContainer xmlns="http://www.canopen.org/xml/1.0" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="http://www.canopen.org/xml/1.0 CANopen.xsd">
	<ISO15745Profile>
		<ProfileBody xsi:type="ProfileBody_Device_CANopen" fileName="" fileCreator="" fileCreationDate="" fileVersion="">
			<DeviceIdentity>
				<vendorName readOnly="true">Nobody</vendorName>
				<vendorID readOnly="true">17</vendorID>
				<productName readOnly="true">Excerpt</productName>
				<productID readOnly="true">0x22</productID>
				<productText readOnly="true"><description lang="en">A drive
whose values were read</description></productText>
				<orderNumber readOnly="true"/>
			</DeviceIdentity>
			<ApplicationProcess>
				<parameterList>
					<parameter uniqueID="UID_PARAM_1000" access="const"><label lang="en">Type</label><UDINT/><denotation><label lang="en"/></denotation><actualValue value="0"/><defaultValue value="0x0"/></parameter>
					<parameter uniqueID="UID_PARAM_1017" access="readWrite"><label lang="en">Heartbeat</label><UINT/><actualValue value="100"/><defaultValue value="0"/></parameter>
				</parameterList>
			</ApplicationProcess>
		</ProfileBody>
	</ISO15745Profile>
	<ISO15745Profile>
		<ProfileBody xsi:type="ProfileBody_CommunicationNetwork_CANopen" fileName="scanned.xdc" fileCreator="" fileCreationDate="2021-03-11" fileCreationTime="9:48:42 PM" fileVersion="0x01">
			<ApplicationLayers communicationEntityType="slave">
				<identity><vendorID>0x00000011</vendorID><productID/></identity>
				<CANopenObjectList>
					<CANopenObject index="1000" name="Device Type" objectType="7" dataType="07" PDOmapping="no" uniqueIDRef="UID_PARAM_1000"/>
					<CANopenObject index="1001" name="Error Register" objectType="7" dataType="05" accessType="ro" defaultValue="" PDOmapping="no" objFlags="0001" actualValue="0x00"/>
					<CANopenObject index="1017" name="Heartbeat" objectType="7" dataType="06" PDOmapping="no" uniqueIDRef="UID_PARAM_1017"/>
					<CANopenObject index="1018" name="Identity" objectType="9" subNumber="2">
						<CANopenSubObject subIndex="00" name="Entries" objectType="7" dataType="05" lowLimit="1" highLimit="4" accessType="ro" defaultValue="1" PDOmapping="no" objFlags="0003" actualValue="1"/>
						<CANopenSubObject subIndex="01" name="Vendor" objectType="7" dataType="07" accessType="ro" defaultValue="" PDOmapping="no" objFlags="0001" actualValue="0x00000011"/>
					</CANopenObject>
				</CANopenObjectList>
			</ApplicationLayers>
			<TransportLayers><PhysicalLayer><baudRate/><baudRate defaultValue="auto-baudRate"><supportedBaudRate value="125 Kbps"/></baudRate></PhysicalLayer></TransportLayers>
			<NetworkManagement>
				<CANopenGeneralFeatures groupMessaging="false" dynamicChannels="0" selfStartingDevice="false" granularity="8" nrOfRxPDO="0" nrOfTxPDO="0" bootUpSlave="true" layerSettingServiceSlave="false"/>
				<deviceCommissioning xmlns="" nodeID="0" nodeName="drive" actualBaudRate="1000000" networkNumber="0" networkName="" CANopenManager="FALSE"/>
			</NetworkManagement>
		</ProfileBody>
	</ISO15745Profile>
</ISO15745ProfileContainer>
